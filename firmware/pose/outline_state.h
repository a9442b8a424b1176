#pragma once
/// What is unknown about the picture of one landmark's outlines.
#include <Eigen/Core>
#include <cmath>
#include <cstddef>

#include "geometry/sheet_motion.h"
#include "geometry/transform.h"

namespace ninedot {

/// Order of the unknowns: rotation (3, about the landmark's origin: angle times kLever_m [m]), translation (3, camera
/// frame [m]), outline offset [px], blur (3) [px^2], tone [1].
inline constexpr int kUnknowns = 11, kPoseUnknowns = 6, kToneUnknown = 10;
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
  /// Of how the camera's curve bends the blur's grey levels (tone.h): 0 linear, or no more than an offset; 1 sRGB.
  double tone = 0;

  SheetMotion motion{};  ///< of the sheet while the rows are exposed; taken as known

  /// Variance of the point spread in its wide direction. [px^2]
  double widest_px2() const noexcept { return blur_px2 + std::hypot(blur_cos_px2, blur_sin_px2); }

  /// Moves the state by a step; keeps blur and tone possible.
  /// \param step  [m] (pose), [px] (offset), [px^2] (blur), [1] (tone)
  void apply(const UnknownVector& step) noexcept;
};

/// What a blur is made of that is much wider along one direction: that is motion, which draws a line of even
/// brightness, where a Gaussian has tails. As many Gaussians, each of a part of the line, have its shape, and all
/// together the variance of the one. Memory: none. Threads: pure.
struct Smear {
  static constexpr std::size_t kMostParts = 6;

  explicit Smear(const OutlineState& state) noexcept;

  std::size_t parts = 1;                              ///< 1: it is no smear, but the blur as it is
  Eigen::Vector2d line_px = Eigen::Vector2d::Zero();  ///< from one end to the other
  double blur_px2, cos_px2, sin_px2;                  ///< of one part: OutlineState's

  /// Variance of a part in its wide direction. [px^2]
  double widest_px2() const noexcept { return blur_px2 + std::hypot(cos_px2, sin_px2); }
};

/// What `state.motion` adds to the blur while a row is exposed: its mean and second harmonic [px^2]. A line of even
/// brightness has a twelfth of its length's square as variance. \param focal_px  of the camera
/// Memory: none. Threads: pure.
Eigen::Vector3d smear_px2(const OutlineState& state, double focal_px) noexcept;

/// The picture that a colour camera's pattern was laid over: before interpolation blurred it, and before a tone curve
/// moved its edges. Memory: none. Threads: pure.
OutlineState before_interpolation(const OutlineState& state) noexcept;

}  // namespace ninedot
