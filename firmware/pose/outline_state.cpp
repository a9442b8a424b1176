#include "pose/outline_state.h"

#include <algorithm>
#include <cmath>

namespace ninedot {
namespace {

// A pixel alone, a square of side 1, has the variance 1/12 = 0.083; no lens is sharper than half of that again.
constexpr double kMinBlur_px2 = 0.12;
// 5 px: wider than the reach of the outermost pixels that are looked at (8 px at 3.1 sigma, outline_refiner.cpp).
constexpr double kMaxBlur_px2 = 25;
// What is left of the smallest blur across its narrow direction.
constexpr double kNarrowShare = 0.8;
// A curve that is steeper than sRGB's; a little of its opposite, for what else bends a blur.
constexpr double kLeastTone = -0.5, kMostTone = 1.5;
// Of the variance, what a triangle over the neighbours adds in the mean over the pattern, each way.
constexpr double kInterpolated_px2 = 0.5;
// A smear's parts are no longer than that: what a Gaussian of its variance is off by from such a line is no more than
// noise. Beside a wider blur a longer part is as near to one: defocus is no smear.
constexpr double kLongestPart_px = 3, kLongestPart_sigmas = 3.6;

}  // namespace

void OutlineState::apply(const UnknownVector& step) noexcept {
  const Eigen::Vector3d rotation_rad = step.head<3>() / kLever_m;
  T_camera_landmark.rotation = exp_so3(rotation_rad) * T_camera_landmark.rotation;
  T_camera_landmark.translation_m += step.segment<3>(3);
  offset_px += step(6);
  blur_px2 = std::clamp(blur_px2 + step(7), kMinBlur_px2, kMaxBlur_px2);
  blur_cos_px2 += step(8);
  blur_sin_px2 += step(9);
  tone = std::clamp(tone + step(kToneUnknown), kLeastTone, kMostTone);
  const double harmonic = std::hypot(blur_cos_px2, blur_sin_px2);
  const double most = blur_px2 - kNarrowShare * kMinBlur_px2;
  if (harmonic > most) blur_cos_px2 *= most / harmonic, blur_sin_px2 *= most / harmonic;
}

Smear::Smear(const OutlineState& state) noexcept
    : blur_px2(state.blur_px2), cos_px2(state.blur_cos_px2), sin_px2(state.blur_sin_px2) {
  const double harmonic_px2 = std::hypot(cos_px2, sin_px2);
  const double length_px = std::sqrt(24 * harmonic_px2);  // a twelfth of its square is twice as much
  const double across_px2 = std::max(blur_px2 - harmonic_px2, 0.0);
  const double longest_px = std::max(kLongestPart_px, kLongestPart_sigmas * std::sqrt(across_px2));
  if (!(length_px > longest_px)) return;
  parts = std::min(static_cast<std::size_t>(std::ceil(length_px / longest_px)), kMostParts);
  const double angle_rad = 0.5 * std::atan2(sin_px2, cos_px2);
  line_px = length_px * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
  const double left = 1 / static_cast<double>(parts * parts);
  blur_px2 -= (1 - left) * harmonic_px2;
  cos_px2 *= left, sin_px2 *= left;
}

Eigen::Vector3d smear_px2(const OutlineState& state, double focal_px) noexcept {
  const Eigen::Vector3d& t_m = state.T_camera_landmark.translation_m;
  if (state.motion.exposure_s == 0 || !(t_m.z() > 0)) return Eigen::Vector3d::Zero();
  const Eigen::Vector2d line_px = focal_px * state.motion.exposure_s * state.motion.ray_velocity(t_m, t_m);
  const double xx = line_px.x() * line_px.x(), yy = line_px.y() * line_px.y();
  return Eigen::Vector3d(xx + yy, xx - yy, 2 * line_px.x() * line_px.y()) / 24;
}

OutlineState before_interpolation(const OutlineState& state) noexcept {
  OutlineState before = state;
  before.offset_px = 0;
  before.apply(-kInterpolated_px2 * UnknownVector::Unit(kPoseUnknowns + 1));
  return before;
}

}  // namespace ninedot
