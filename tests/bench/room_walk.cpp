#include "tests/bench/room_walk.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "base/contract.h"
#include "tests/support/renderer_optics.h"
#include "world/landmark_codes.h"

namespace ninedot::bench {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kSwing_rad = 12 * kDegree, kSwingRate_rad_s = 1.3;  // of the head, about 25 degrees ahead of the wall
constexpr double kSheet_m = 0.19;     // of its side, what has to be in the picture: a little more than the ring
constexpr double kLeastDot_px = 2.2;  // smaller ones are not asked for

test::LinearRgb random_colour(test::Random& random) {
  return {random.uniform(0.05, 0.8), random.uniform(0.05, 0.8), random.uniform(0.05, 0.8)};
}

/// As bright as daylight, for a camera with an automatic exposure.
test::LinearRgb evened(test::LinearRgb light) {
  const double luma = 0.299 * light.red + 0.587 * light.green + 0.114 * light.blue;
  return {light.red / luma, light.green / luma, light.blue / luma};
}

/// Twelve landmarks on the long wall, four on the one ahead; a poster between any two.
test::Room furnished_room(const RoomCondition& condition, test::Random& random) {
  test::Room room;
  room.low_m = {-6, -4, 0}, room.high_m = {6, 4, 2.8};
  room.wall = {random.uniform(0.3, 0.5), 0.15, 0.12, random.bits()};
  room.lamp = {{random.uniform(-2, 2), random.uniform(-1, 1), 2.6}, 0.55, 1.2, 2};
  room.light = evened(test::light_of_kelvin(condition.light_kelvin));
  const auto hang = [&](test::RoomSide side, double along_m) {
    const auto code = known_code(static_cast<int>(room.landmarks.size()) + 1);
    room.landmarks.push_back(
        {side, along_m + random.uniform(-0.12, 0.12), random.uniform(1.15, 1.5), test::inks_of_code(code.value())});
    const double beside_m = along_m + random.uniform(0.35, 0.45);
    room.posters.push_back({side, beside_m, random.uniform(0.9, 1.8), random.uniform(0.1, 0.25),
                            random.uniform(0.2, 0.7), random_colour(random)});
  };
  for (int i = 0; i < 12; ++i) hang(test::RoomSide::kHighY, -4.4 + 0.8 * i);
  for (int i = 0; i < 4; ++i) hang(test::RoomSide::kHighX, -2.4 + 1.6 * i);
  return room;
}

}  // namespace

RoomWalk::RoomWalk(const RoomCondition& condition, test::Random random)
    : room_(furnished_room(condition, random)),
      speed_m_s_(condition.speed_m_s),
      exposure_s_(condition.exposure_s),
      readout_s_(condition.readout_s),
      distance_m_(condition.distance_m),
      start_m_(random.uniform(-4.5, 2), room_.high_m[1] - condition.distance_m, random.uniform(1.2, 1.45)),
      phase_rad_(random.uniform(-std::numbers::pi, std::numbers::pi)) {
  EXPECTS(condition.distance_m < room_.high_m[1] - room_.low_m[1]);
}

test::CameraPose RoomWalk::camera_at(double time_s) const {
  const double t_s = speed_m_s_ > 0 ? time_s : 0;
  const Eigen::Vector3d p_m = start_m_ + Eigen::Vector3d(speed_m_s_ * t_s, 0, 0.004 * std::sin(2.6 * t_s + phase_rad_));
  const double yaw_rad = 65 * kDegree + kSwing_rad * std::sin(kSwingRate_rad_s * t_s + phase_rad_);
  const double pitch_rad = 0.004 * std::sin(1.7 * t_s + phase_rad_), roll_rad = 0.006 * std::sin(2.1 * t_s);
  const Eigen::Vector3d ahead(std::cos(yaw_rad) * std::cos(pitch_rad), std::sin(yaw_rad) * std::cos(pitch_rad),
                              std::sin(pitch_rad));
  const Eigen::Vector3d right = ahead.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d level;
  level << right, ahead.cross(right), ahead;
  const Eigen::Quaterniond q(level * Eigen::AngleAxisd(roll_rad, Eigen::Vector3d::UnitZ()));
  return {{p_m.x(), p_m.y(), p_m.z()}, {q.w(), q.x(), q.y(), q.z()}};
}

test::Shutter RoomWalk::shutter(const test::Lens& lens) const {
  test::Shutter shutter{0, readout_s_ / lens.height_px};
  if (speed_m_s_ <= 0) return shutter;  // nothing to blur
  const double fastest_px_s = lens.fx_px * (speed_m_s_ / distance_m_ + kSwing_rad * kSwingRate_rad_s);
  shutter.exposure_s = exposure_s_;
  shutter.sub_exposures = std::max(2, static_cast<int>(std::ceil(exposure_s_ * fastest_px_s)));
  return shutter;
}

std::vector<std::size_t> landmarks_shown(const test::Room& room, const test::Lens& lens,
                                         const test::CameraPose& camera) {
  const Eigen::Matrix3d R_camera_world = test::rotation_of(camera).transpose();
  const Eigen::Vector3d camera_m(camera.position_m.data());
  const auto is_inside = [&](const Eigen::Vector3d& p_m) {
    const Eigen::Vector3d in_camera_m = R_camera_world * (p_m - camera_m);
    if (in_camera_m.z() < 0.1) return false;
    const double u = lens.cx_px + lens.fx_px * in_camera_m.x() / in_camera_m.z();
    const double v = lens.cy_px + lens.fy_px * in_camera_m.y() / in_camera_m.z();
    return u > 2 && v > 2 && u < lens.width_px - 3 && v < lens.height_px - 3;
  };
  std::vector<std::size_t> shown;
  for (std::size_t i = 0; i < room.landmarks.size(); ++i) {
    const Eigen::Vector3d place_m = test::place_of(room, room.landmarks[i]);
    const Eigen::Matrix3d axes = test::axes_of(room.landmarks[i].side);
    const Eigen::Vector3d sight_m = camera_m - place_m;
    const double facing = sight_m.normalized().dot(axes.col(1));
    const double dot_px = lens.fx_px * 0.0254 / sight_m.norm() * facing;
    bool whole = dot_px >= kLeastDot_px;
    for (const double x : {-0.5, 0.5})
      for (const double z : {-0.5, 0.5})
        whole = whole && is_inside(place_m + kSheet_m * (x * axes.col(0) + z * axes.col(2)));
    if (whole) shown.push_back(i);
  }
  return shown;
}

}  // namespace ninedot::bench
