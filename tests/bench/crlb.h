#pragma once
/// The Cramer-Rao bound of one frame: the smallest error that any unbiased estimator of the pose can have.
///
/// Model: pixel = paper + (ink - paper) Phi(-d / b), d its signed distance in px to the nearest outline and
/// b^2 = point spread^2 + 1/12 (the pixel's square); independent noise of variance a L + b in linear light, plus that
/// of rounding to whole grey levels. Unknown: the six of the pose, and as nuisances paper, ink (of discs of several
/// inks: how much darker or lighter all of them are than they are said to be) and blur. The camera is known. With J the
/// derivatives of all pixels, the bound is the pose block of (J^T diag(1 / variance) J)^-1 (S. Kay, "Fundamentals of
/// Statistical Signal Processing: Estimation Theory", 1993, section 3.9).
#include <Eigen/Core>
#include <optional>

#include "tests/support/renderer.h"

namespace ninedot::bench {

struct PoseBound {
  /// Of (position in S0 [m], rotation vector in the camera frame [rad]), in the convention of PoseEstimate::covariance.
  Eigen::Matrix<double, 6, 6> covariance;
  double position_m = 0;  ///< 1 sigma, the three axes together: root of the trace
  double rotation_rad = 0;
  double along_m = 0;  ///< along the line of sight to P9
};

/// The landmark is the scene's first sheet. What lies outside of the picture or behind the board tells nothing.
/// The light is taken as even: gradients and shadows are not part of the bound.
/// \return  nothing where the visible part does not determine a pose
std::optional<PoseBound> cramer_rao_bound(const test::Scene& scene);

}  // namespace ninedot::bench
