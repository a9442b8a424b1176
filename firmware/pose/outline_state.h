#pragma once
/// What is unknown about the picture of one landmark's outlines.
#include <Eigen/Core>

#include "geometry/sheet_motion.h"
#include "geometry/transform.h"

namespace ninedot {

/// Order of the unknowns: rotation (3, about the landmark's origin: angle times kLever_m [m]), translation (3, camera
/// frame [m]), outline offset [px], blur (3) [px^2].
inline constexpr int kUnknowns = 10, kPoseUnknowns = 6;
using UnknownMatrix = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using UnknownVector = Eigen::Matrix<double, kUnknowns, 1>;
/// Makes a unit of rotation move the ring as far as a unit of translation: the default ring's radius. Scaling alone:
/// the equations are solved exactly whatever it is.
inline constexpr double kLever_m = 0.08;

struct OutlineState {
  CameraFromLandmark T_camera_landmark;
  double offset_px = 0;   ///< outlines are this much further out than the pose says
  double blur_px2 = 0.7;  ///< variance of the point spread, mean over directions
  /// Its second harmonic [px^2]: half of the variance along x minus along y; and the same of the diagonals.
  double blur_cos_px2 = 0, blur_sin_px2 = 0;

  SheetMotion motion{};  ///< of the sheet while the rows are exposed; taken as known

  /// Moves the state by a step; keeps the blur possible. \param step  [m] (pose), [px] (offset), [px^2] (blur)
  void apply(const UnknownVector& step) noexcept;
};

/// The picture that a colour camera's pattern was laid over: before interpolation blurred it, and before a tone curve
/// moved its edges. Memory: none. Threads: pure.
OutlineState before_interpolation(const OutlineState& state) noexcept;

}  // namespace ninedot
