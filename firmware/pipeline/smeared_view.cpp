#include "pipeline/smeared_view.h"

#include <array>
#include <chrono>

namespace ninedot {
namespace {

// Lines that dots draw: from here on those of a ring 4 m away begin to run together, and pictures that are taken back
// show more of them.
constexpr double kSmeared_px = 4;
// Slower landmarks say nothing of the exposure. A robot that turns by 30 degrees per second: 300 px/s.
constexpr double kFast_px_s = 200;

}  // namespace

void SmearedView::begin(const Frame& frame, const CameraModel& camera,
                        const std::optional<CameraTwist>& tracked) noexcept {
  const double told_s = std::chrono::duration<double>(frame.exposure_end - frame.exposure_begin).count();
  is_told_ = told_s > 0;
  exposure_s_ = is_told_ ? told_s : belief_.exposure_s().value_or(0);
  twist_ = tracked;
  const bool is_whole = frame.luma.width_px == camera.width_px && frame.luma.height_px == camera.height_px;
  if (!twist_ && is_whole) {
    const auto turned = gyro_.turn(frame, camera);
    if (turned && line_px(*turned, camera) > kSmeared_px) twist_ = turned;
  }
  is_smeared_ = is_whole && twist_ && line_px(*twist_, camera) > kSmeared_px;
}

/// What a point in the picture's middle draws.
double SmearedView::line_px(const CameraTwist& twist, const CameraModel& camera) const noexcept {
  return twist.angular_velocity_rad_s.head<2>().norm() * exposure_s_ * camera.fx_px;
}

ImageView SmearedView::unblurred(const ImageView& luma, const CameraModel& camera) noexcept {
  std::array<MotionUnblur::Line, MotionUnblur::kStrips> lines{};
  for (std::size_t s = 0; s < lines.size() && twist_; ++s) {
    const double x_px = (static_cast<double>(s) + 0.5) / static_cast<double>(lines.size()) * camera.width_px;
    const Eigen::Vector3d ray((x_px - camera.cx_px) / camera.fx_px, 0, 1);
    const SheetMotion turning{Eigen::Vector3d::Zero(), -twist_->angular_velocity_rad_s.cross(ray)};
    const Eigen::Vector2d line = exposure_s_ * turning.ray_velocity(ray, ray);
    lines[s] = {static_cast<float>(camera.fx_px * line.x()), static_cast<float>(camera.fy_px * line.y())};
  }
  return unblur_.of(luma, lines);
}

void SmearedView::note(const SheetMotion& motion, const OutlineState& outlines, const CameraModel& camera) noexcept {
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
