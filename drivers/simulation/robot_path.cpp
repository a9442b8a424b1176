#include "drivers/simulation/robot_path.h"

#include <algorithm>

#include "base/contract.h"

namespace ninedot {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

Eigen::Isometry3d turned(const Vector3d& rpy_rad) noexcept {
  return Eigen::Isometry3d(AngleAxisd(rpy_rad.z(), Vector3d::UnitZ()) * AngleAxisd(rpy_rad.y(), Vector3d::UnitY()) *
                           AngleAxisd(rpy_rad.x(), Vector3d::UnitX()));
}

Eigen::Isometry3d moved(const Vector3d& by_m) noexcept { return Eigen::Isometry3d(Eigen::Translation3d(by_m)); }

}  // namespace

WayPoint place_on(const std::vector<WayPoint>& path, double t_s) noexcept {
  EXPECTS(!path.empty());
  const auto next = std::ranges::upper_bound(path, t_s, {}, &WayPoint::t_s);
  if (next == path.begin()) return path.front();
  if (next == path.end()) return path.back();
  const WayPoint& a = *(next - 1);
  const WayPoint& b = *next;
  const double part = (t_s - a.t_s) / (b.t_s - a.t_s);
  return {t_s, a.position_m + part * (b.position_m - a.position_m),
          a.heading_rad + part * (b.heading_rad - a.heading_rad)};
}

Eigen::Isometry3d world_from_camera(const WayPoint& body, const HeadMount& mount, const HeadAngles& head) noexcept {
  Eigen::Matrix3d optical;  // columns: the camera's right, down and forward in a body's axes
  optical.col(0) = -Vector3d::UnitY();
  optical.col(1) = -Vector3d::UnitZ();
  optical.col(2) = Vector3d::UnitX();
  return moved(body.position_m) * turned({0, 0, body.heading_rad}) * moved(mount.pan_axis_m) *
         turned(mount.mount_rpy_rad) * turned({0, 0, head.pan_rad}) * moved(mount.tilt_axis_m) *
         turned({0, -head.tilt_rad, 0}) * moved(mount.camera_m) * turned(mount.camera_rpy_rad) *
         Eigen::Isometry3d(optical);
}

}  // namespace ninedot
