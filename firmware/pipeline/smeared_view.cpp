#include "pipeline/smeared_view.h"

#include <array>

namespace ninedot {
namespace {

// Lines that dots draw: from here on those of a ring 4 m away begin to run together, and pictures that are taken back
// show more of them.
constexpr double kSmeared_px = 4;
// From here on the pictures are asked as well where a track knows: it may have lost the camera.
constexpr double kMaySmear_px = 3;

/// A track may know it better than the pictures, or not at all.
bool agree(const CameraTwist& tracked, const CameraTwist& turned) noexcept {
  const Eigen::Vector2d apart_rad_s = (tracked.angular_velocity_rad_s - turned.angular_velocity_rad_s).head<2>();
  return apart_rad_s.norm() < 2 * turned.rate_sigma_rad_s;
}

}  // namespace

void SmearedView::begin(const Frame& frame, const CameraModel& camera,
                        const std::optional<CameraTwist>& tracked) noexcept {
  exposure_.begin(frame);
  twist_ = tracked;
  const bool is_whole = frame.luma.width_px == camera.width_px && frame.luma.height_px == camera.height_px;
  if (is_whole && (!tracked || line_px(*tracked, camera) > kMaySmear_px)) {
    const auto turned = gyro_.turn(frame, camera);
    if (turned && line_px(*turned, camera) > kSmeared_px && !(tracked && agree(*tracked, *turned))) twist_ = turned;
  }
  is_smeared_ = is_whole && twist_ && line_px(*twist_, camera) > kSmeared_px;
}

/// What a point in the picture's middle draws.
double SmearedView::line_px(const CameraTwist& twist, const CameraModel& camera) const noexcept {
  return twist.angular_velocity_rad_s.head<2>().norm() * exposure_s() * camera.fx_px;
}

ImageView SmearedView::unblurred(const ImageView& luma, const CameraModel& camera) noexcept {
  std::array<MotionUnblur::Line, MotionUnblur::kStrips> lines{};
  for (std::size_t s = 0; s < lines.size() && twist_; ++s) {
    const double x_px = (static_cast<double>(s) + 0.5) / static_cast<double>(lines.size()) * camera.width_px;
    const Eigen::Vector3d ray((x_px - camera.cx_px) / camera.fx_px, 0, 1);
    const SheetMotion turning{Eigen::Vector3d::Zero(), -twist_->angular_velocity_rad_s.cross(ray)};
    const Eigen::Vector2d line = exposure_s() * turning.ray_velocity(ray, ray);
    lines[s] = {static_cast<float>(camera.fx_px * line.x()), static_cast<float>(camera.fy_px * line.y())};
  }
  return unblur_.of(luma, lines);
}

}  // namespace ninedot
