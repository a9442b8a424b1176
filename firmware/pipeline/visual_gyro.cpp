#include "pipeline/visual_gyro.h"

#include <chrono>

namespace ninedot {
namespace {

// Pictures that lie further apart have not gained speed evenly; nor do they show much of the same.
constexpr double kLongest_s = 0.2;
// Of the turning: what a camera that also moves makes of it, and what it gains from one picture to the next
// (VisualGyro.KnowsHowTheCameraTurns: 0.35 of 2.8 rad/s at most where it gains 0.6 rad/s in each).
constexpr double kUnknownShare = 0.15;

}  // namespace

std::optional<CameraTwist> VisualGyro::turn(const Frame& frame, const CameraModel& camera) noexcept {
  const double since_s = std::chrono::duration<double>(frame.exposed_at() - at_).count();
  at_ = frame.exposed_at();
  if (!(since_s > 0 && since_s < kLongest_s)) shift_.forget(), rate_rad_s_.reset();
  const auto shifted = shift_.to(frame.luma);
  const auto before = rate_rad_s_;
  rate_rad_s_.reset();
  if (!shifted) return std::nullopt;
  // What the camera sees moves against its turning.
  rate_rad_s_ = Eigen::Vector3d(shifted->y_px / camera.fy_px, -shifted->x_px / camera.fx_px, 0) / since_s;
  CameraTwist twist;
  twist.angular_velocity_rad_s = *rate_rad_s_;
  if (before) twist.angular_velocity_rad_s += 0.5 * (*rate_rad_s_ - *before);
  twist.rate_sigma_rad_s = kUnknownShare * twist.angular_velocity_rad_s.norm();
  return twist;
}

}  // namespace ninedot
