#include "tests/bench/room_bound.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

#include "tests/bench/crlb.h"
#include "tests/support/renderer_optics.h"

namespace ninedot::bench {
namespace {

using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// ITU-R BT.601.
double luma_of(const test::LinearRgb& colour, const test::LinearRgb& light) {
  return 0.299 * colour.red * light.red + 0.587 * colour.green * light.green + 0.114 * colour.blue * light.blue;
}

}  // namespace

test::Scene scene_of_landmark(const test::Room& room, const test::HungLandmark& landmark, const test::Lens& lens,
                              const test::Sensor& sensor, const test::CameraPose& camera) {
  const Eigen::Matrix3d axes = test::axes_of(landmark.side);
  const Eigen::Vector3d place_m = test::place_of(room, landmark);
  const Eigen::Vector3d at_m = axes.transpose() * (Eigen::Vector3d(camera.position_m.data()) - place_m);
  const Eigen::Quaterniond q(axes.transpose() * test::rotation_of(camera));
  test::Scene scene;
  scene.lens = lens, scene.sensor = sensor;
  scene.camera = {{at_m.x(), at_m.y(), at_m.z()}, {q.w(), q.x(), q.y(), q.z()}};
  const Eigen::Vector3d to_lamp_m = Eigen::Vector3d(room.lamp.position_m.data()) - place_m;
  scene.light.level = test::irradiance(room.lamp, to_lamp_m, axes.col(1));
  test::Sheet& sheet = scene.sheets.front();
  sheet.reflectance = luma_of(landmark.paper, room.light);
  for (std::size_t i = 0; i < sheet.discs.size(); ++i)
    sheet.discs[i].reflectance = luma_of(landmark.discs[i], room.light);
  return scene;
}

std::optional<double> room_bound_m(const test::Room& room, std::span<const std::size_t> shown, const test::Lens& lens,
                                   const test::Sensor& sensor, const test::CameraPose& camera) {
  Matrix6d information = Matrix6d::Zero();
  for (const std::size_t i : shown) {
    const test::HungLandmark& landmark = room.landmarks[i];
    const auto bound = cramer_rao_bound(scene_of_landmark(room, landmark, lens, sensor, camera));
    if (!bound) continue;
    // The position is along the landmark's axes, the rotation about the camera's, which are the same for all.
    Matrix6d to_world = Matrix6d::Identity();
    to_world.topLeftCorner<3, 3>() = test::axes_of(landmark.side);
    information += to_world * bound->covariance.inverse() * to_world.transpose();
  }
  if (information.isZero()) return std::nullopt;
  return std::sqrt(information.inverse().topLeftCorner<3, 3>().trace());
}

}  // namespace ninedot::bench
