#include "pipeline/picture_exposure.h"

#include <chrono>
#include <cmath>

namespace ninedot {
namespace {

// Slower landmarks say nothing of the exposure. A robot that turns by 30 degrees per second: 300 px/s.
constexpr double kFast_px_s = 200;

}  // namespace

void PictureExposure::begin(const Frame& frame) noexcept {
  const double told_s = std::chrono::duration<double>(frame.exposure_end - frame.exposure_begin).count();
  is_told_ = told_s > 0;
  seconds_ = is_told_ ? told_s : belief_.exposure_s().value_or(0);
}

void PictureExposure::note(const SheetMotion& motion, const OutlineState& outlines,
                           const CameraModel& camera) noexcept {
  const Eigen::Vector3d& t_m = outlines.T_camera_landmark.translation_m;
  if (is_told_ || !(t_m.z() > 0)) return;
  const Eigen::Vector2d speed_px_s = camera.fx_px * motion.ray_velocity(t_m, t_m);
  const double speed2 = speed_px_s.squaredNorm();
  if (!(speed2 > kFast_px_s * kFast_px_s)) return;
  // The blur's second harmonic along the motion.
  const double x2 = speed_px_s.x() * speed_px_s.x(), y2 = speed_px_s.y() * speed_px_s.y();
  const double along_px2 =
      (outlines.blur_cos_px2 * (x2 - y2) + outlines.blur_sin_px2 * 2 * speed_px_s.x() * speed_px_s.y()) / speed2;
  belief_.note(std::sqrt(speed2), along_px2);
}

}  // namespace ninedot
