#pragma once
/// The picture of the landmark along its outlines, and how it changes with the pose: one Gauss-Newton step's
/// ingredients.
///
/// METHOD, section 3: I = paper + (ink - paper) Phi(-d / s), d the signed distance to a projected disc's outline [px].
/// Unknown everywhere: six of pose, a common offset of all outlines (tone curves), three of the blur (it may be wider
/// in one direction: motion). Unknown in each group: paper, ink, and the paper's slope; these are linear and are
/// eliminated group by group (Golub & Pereyra, "The differentiation of pseudo-inverses and nonlinear least squares
/// problems whose variables separate", SIAM J. Numer. Anal. 10, 1973).
#include <Eigen/Core>

#include "pose/outline_pixels.h"

namespace ninedot {

/// Order of the unknowns: rotation (3, about the landmark's origin, in units of kLever_m), translation (3, camera
/// frame), outline offset, blur (3).
inline constexpr int kUnknowns = 10;
using UnknownMatrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using UnknownVector = Eigen::Matrix<double, kUnknowns, 1>;
inline constexpr double kLever_m = 0.08;  ///< makes a unit of rotation move the ring as far as a unit of translation

struct OutlineState {
  CameraFromLandmark T_camera_landmark;
  double offset_px = 0;   ///< outlines are this much further out than the pose says
  double blur_px2 = 0.7;  ///< variance of the point spread, mean over directions
  double blur_cos_px2 = 0,
         blur_sin_px2 = 0;  ///< its second harmonic: variance along x minus along y, halves; and diagonal

  /// Moves the state by a step; keeps the blur possible.
  void apply(const UnknownVector& step) noexcept;
};

/// What one group says.
struct GroupFit {
  bool usable = false;
  double squared_residuals = 0;
  double shift_px = 0;           ///< by how much its outline lies further out than the state says
  double shift_information = 0;  ///< inverse variance of shift_px, times the noise's variance [1 / px^2 LSB^2]
  double contrast_lsb = 0, paper_lsb = 0;
  int degrees_of_freedom = 0;
  UnknownMatrix normal;    ///< J^T J with the group's own unknowns eliminated
  UnknownVector gradient;  ///< J^T r
};

/// Evaluates one group at a state. \param with_normal  false: residuals only
/// Memory: none. Threads: pure.
void fit_group(const OutlinePixels& pixels, const OutlineGroup& group, const LandmarkGeometry& landmark,
               const OutlineState& state, bool with_normal, GroupFit& fit) noexcept;

}  // namespace ninedot
