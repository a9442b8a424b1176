#include "tests/calibrate_head/made_up_head.h"

#include <cmath>

#include "geometry/landmark.h"
#include "tests/support/random.h"

namespace ninedot::test {
namespace {

/// The tilt axis leans by a turn of its own about the panned x axis: before and back again.
BodyFromCamera skewed_camera(const MadeUpHeadOptions& options, const HeadAngles& angles) {
  const Eigen::Matrix3d lean = exp_so3({options.skew_rad, 0, 0});
  const Eigen::Matrix3d pan = exp_so3({0, 0, angles.pan_rad});
  const Eigen::Matrix3d tilt = lean * exp_so3({0, -angles.tilt_rad, 0}) * lean.transpose();
  const BodyGeometry& body = options.body;
  const Eigen::Matrix3d camera = camera_on_body({.camera_rpy_rad = body.camera_rpy_rad}, {}).T_body_camera.rotation;
  return {pan * tilt * camera, pan * (body.tilt_axis_m + tilt * body.camera_m)};
}

/// Upright, before the head, each a hand's breadth beside the one before and turned towards the head.
Transform<frame::Body, frame::Landmark> hung(const MadeUpHeadOptions& options, int index, bool is_moved) {
  // The landmark's X to the viewer's left is the body's y, its Y out of the sheet looks back along x.
  Eigen::Matrix3d facing;
  facing << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  const double aside_m = 0.45 * (index - 0.5 * (options.landmarks - 1)) + (is_moved ? 0.06 : 0);
  return {exp_so3({0.1, 0.25, 0.3 + 0.2 * index}) * facing, {options.distance_m, aside_m, 0.05 * index}};
}

bool is_in_picture(const CameraFromLandmark& T) {
  const Eigen::Vector3d& p = T.translation_m;
  const double ring = 0.09 / p.z();
  return p.z() > 0.2 && std::abs(p.x() / p.z()) + ring < 320 / kMadeUpFocalLength_px &&
         std::abs(p.y() / p.z()) + ring < 240 / kMadeUpFocalLength_px;
}

/// The other reading of a plane that is seen from nearly in front: its tilt towards the other side.
CameraFromLandmark mirrored(const CameraFromLandmark& T) {
  const Eigen::Vector3d sight = T.translation_m.normalized(), normal = T.rotation.col(1);
  const Eigen::Vector3d other = 2 * sight.dot(normal) * sight - normal;
  return {Eigen::Quaterniond::FromTwoVectors(normal, other).toRotationMatrix() * T.rotation, T.translation_m};
}

}  // namespace

double MadeUpAxis::true_rad(double told_rad) const {
  return offset_rad + scale * told_rad + bend_rad * std::sin(told_rad / 0.25);
}

LandmarkSighting made_up_sighting(const CameraFromLandmark& T_camera_landmark, double noise_px, std::uint64_t seed) {
  Random random(seed);
  const LandmarkGeometry landmark;
  LandmarkSighting seen{0, T_camera_landmark, {}};
  const double sigma = std::max(noise_px, 1e-6) / kMadeUpFocalLength_px;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d on_sheet_m = landmark.centre_m(dot);
    const Eigen::Vector3d p = T_camera_landmark * Eigen::Vector3d(on_sheet_m.x(), 0, on_sheet_m.y());
    const double x = random.normal(), y = random.normal();
    seen.dots[dot].ray = p.hnormalized() + sigma * Eigen::Vector2d(x, y);
    seen.dots[dot].information = Eigen::Matrix2d::Identity() / (sigma * sigma);
  }
  return seen;
}

std::vector<HeadStop> made_up_stops(const MadeUpHeadOptions& options) {
  Random random(options.seed);
  std::vector<HeadStop> stops;
  const auto told = [](const MadeUpAxis& axis, int i) {
    return axis.from_rad + (axis.to_rad - axis.from_rad) * i / (axis.stops - 1);
  };
  for (const int way : {1, -1}) {
    for (int r = 0; r < options.tilt.stops; ++r) {
      const int row = way > 0 ? r : options.tilt.stops - 1 - r, side = (r % 2 == 0 ? 1 : -1) * way;
      for (int c = 0; c < options.pan.stops; ++c) {
        const int column = side > 0 ? c : options.pan.stops - 1 - c;
        HeadStop stop{0, {told(options.pan, column), told(options.tilt, row)}, side, way, {}};
        const auto stands = [&](const MadeUpAxis& axis, double told_rad, int from) {
          return axis.true_rad(told_rad) - std::copysign(from, from * axis.scale) * axis.play_rad / 2 +
                 axis.spread_rad * random.normal();
        };
        HeadAngles angles{stands(options.pan, stop.told.pan_rad, side), stands(options.tilt, stop.told.tilt_rad, way)};
        const std::size_t number = stops.size() + 1;
        if (number % options.slips_every == 0) angles.pan_rad += 0.05;
        const BodyFromCamera T_foot_camera = skewed_camera(options, angles);
        for (int i = 0; i < options.landmarks; ++i) {
          const CameraFromLandmark T = T_foot_camera.inverse() * hung(options, i, number > options.moved_after);
          if (!is_in_picture(T)) continue;
          stop.seen.push_back(made_up_sighting(T, options.noise_px, random.bits()));
          stop.seen.back().id = static_cast<std::uint16_t>(i + 1);
          if (number % options.mirrored_every == 0) stop.seen.back().T_camera_landmark = mirrored(T);
        }
        if (!stop.seen.empty()) stops.push_back(stop);
      }
    }
  }
  return stops;
}

}  // namespace ninedot::test
