#pragma once
/// What is believed of a lens before any picture: enough to keep finite what no picture shows.
#include <Eigen/Core>
#include <array>

#include "geometry/camera_model.h"

namespace ninedot {

/// Nothing of fx to cy. A coefficient of plumb_bob and equidistant bends the picture's corner by 0.4 of its distance
/// from the middle, 1-sigma.
///
/// The radial coefficients of a rational polynomial mean little one by one: numerator N and denominator D may be
/// multiplied by any common factor, and one that has a root in the picture makes a pole there that no view notices. So
/// what is believed is of N and D themselves, at three radii up to the picture's corner: N / D bends by 0.7 (as three
/// coefficients of 0.4 do), and 1 / D, which a pole would make infinite, is 1 +- 1.
/// Threads: const is safe.
class LensPrior {
 public:
  /// \param lens  about as it will be found: how far out its picture reaches
  explicit LensPrior(const CameraModel& lens);

  Eigen::Index count() const noexcept { return count_; }  ///< number of residuals
  /// \param values  as parameters_of gives them [px], [1] \param residuals  count(), in sigmas [1]
  /// \param jacobian  residuals by values [1/px], [1]; null: not asked \return  false: D is not positive everywhere up
  /// to the corner
  bool evaluate(const Eigen::Ref<const Eigen::VectorXd>& values, Eigen::VectorXd& residuals,
                Eigen::MatrixXd* jacobian) const;

 private:
  static constexpr std::size_t kRadii = 3;

  DistortionModel model_;
  Eigen::Index count_ = 0;
  Eigen::VectorXd sigmas_;  ///< of the coefficients; infinite: nothing
  std::array<double, kRadii> squared_radii_{};
};

}  // namespace ninedot
