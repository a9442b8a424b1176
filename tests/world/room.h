#pragma once
/// Random rooms: landmarks on their walls, a camera, and what it sees of them, with noise as a picture has it.
#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "geometry/camera_model.h"
#include "geometry/planar_pose.h"
#include "pose/mirror_image.h"
#include "tests/support/random.h"
#include "world/joint_fit.h"
#include "world/world_solver.h"

namespace ninedot::test {

inline constexpr double kFocal_px = 600;
inline constexpr double kDeg = std::numbers::pi / 180;

/// The camera that sees them.
inline CameraModel camera_of_rooms() {
  CameraModel camera;
  camera.fx_px = camera.fy_px = kFocal_px;
  return camera;
}

struct RoomOptions {
  int landmarks = 3;
  double nearest_m = 1, farthest_m = 6;
  double most_tilt_rad = 60 * kDeg;
  bool coded = true;
};

struct Room {
  std::vector<PlacedLandmark> map;
  WorldFromCamera T_world_camera;
};

/// A camera that looks along the world's X turned by `heading`, level but for small angles.
inline Eigen::Matrix3d level_camera(double heading_rad, double pitch_rad, double roll_rad) {
  Eigen::Matrix3d R_body_camera;  // x to the body's -Y, y to -Z, z to X
  R_body_camera << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return exp_so3({0, 0, heading_rad}) * R_body_camera * exp_so3({pitch_rad, 0, 0}) * exp_so3({0, 0, roll_rad});
}

/// An upright sheet on the ray (x, y, 1) at a distance, turned away from the camera by a tilt about the vertical.
inline WorldFromLandmark sheet_at(const WorldFromCamera& T_world_camera, const Eigen::Vector2d& ray, double distance_m,
                                  double tilt_rad) {
  const Eigen::Vector3d p9 = T_world_camera * Eigen::Vector3d(distance_m * ray.homogeneous().normalized());
  const Eigen::Vector3d to_camera = T_world_camera.translation_m - p9;
  return place_upright(p9, std::atan2(to_camera.y(), to_camera.x()) - std::numbers::pi / 2 + tilt_rad);
}

inline Room random_room(Random& random, const RoomOptions& options) {
  Room room;
  room.T_world_camera.rotation =
      level_camera(random.uniform(-3, 3), random.uniform(-0.2, 0.2), 4 * kDeg * random.normal());
  room.T_world_camera.translation_m = {random.uniform(-5, 5), random.uniform(-5, 5), random.uniform(0.5, 2)};
  while (static_cast<int>(room.map.size()) < options.landmarks) {
    const Eigen::Vector2d ray(random.uniform(-0.5, 0.5), random.uniform(-0.35, 0.35));
    const WorldFromLandmark place =
        sheet_at(room.T_world_camera, ray, random.uniform(options.nearest_m, options.farthest_m),
                 random.uniform(-options.most_tilt_rad, options.most_tilt_rad));
    const bool is_free = std::ranges::none_of(room.map, [&](const PlacedLandmark& other) {
      return (other.T_world_landmark.translation_m - place.translation_m).norm() < 0.3;
    });
    if (is_free) room.map.push_back({.T_world_landmark = place, .is_black_and_white = !options.coded});
  }
  return room;
}

/// What the camera sees of a landmark: rays with a noise of 0.03 to 0.08 px that differs by direction, both planar
/// solutions of them as a solver finds them. \param turn  numbered from another dot than P1
inline SightedLandmark sighting_of(Random& random, const WorldFromCamera& T_world_camera,
                                   const WorldFromLandmark& T_world_landmark, std::size_t turn = 0) {
  const LandmarkGeometry landmark;
  const CameraFromLandmark truth = T_world_camera.inverse() * T_world_landmark;
  SightedLandmark seen;
  std::array<PlanePoint, kDotCount> points;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const std::size_t printed = dot == kCentreDot ? dot : (dot + kRingDotCount - turn) % kRingDotCount;
    const Eigen::Vector2d on_sheet_m = landmark.centre_m(printed);
    const Eigen::Vector2d sigma = Eigen::Vector2d(random.uniform(0.03, 0.08), random.uniform(0.03, 0.08)) / kFocal_px;
    const Eigen::Rotation2Dd axes(random.uniform(0, std::numbers::pi));
    const Eigen::Vector2d noise = axes * sigma.cwiseProduct(Eigen::Vector2d(random.normal(), random.normal())).eval();
    DotSighting& sighted = seen.sighting.dots[dot];
    sighted.ray = (truth * Eigen::Vector3d(on_sheet_m.x(), 0, on_sheet_m.y())).hnormalized() + noise;
    sighted.information =
        axes.toRotationMatrix() * sigma.cwiseAbs2().cwiseInverse().asDiagonal() * axes.toRotationMatrix().transpose();
    points[dot] = {landmark.centre_m(dot), sighted.ray, sighted.information.trace()};
  }
  // Both likeliest poses, each refined by itself: nearly frontal, the two planar solutions may end in one.
  const auto refined = [&](const CameraFromLandmark& T) {
    const JointMember member{&seen.sighting, {}, nullptr};
    const auto back = T.inverse();
    JointFit fit;
    fit_jointly({&member, 1}, {back.rotation, back.translation_m}, landmark, fit);
    const auto best = fit.T_world_camera.inverse();
    return std::pair(CameraFromLandmark{best.rotation, best.translation_m}, fit.sum.chi2);
  };
  const PlanarPoses both = solve_planar_pose(points).value();
  auto believed = refined(both[0].T_camera_landmark), other = refined(both[1].T_camera_landmark);
  if (angle_between_rad(believed.first, other.first) < kSamePose_rad)
    other = refined(mirror_image(believed.first, landmark));
  if (other.second < believed.second) std::swap(believed, other);
  seen.sighting.T_camera_landmark = believed.first;
  const double above = other.second - believed.second;
  if (above < 50 && angle_between_rad(believed.first, other.first) > kSamePose_rad) {
    seen.mirror = other.first;
    seen.mirror_chi2_above = above;
  }
  seen.numbering_costs = upright_costs(seen.sighting.T_camera_landmark, landmark, UprightPrior{});
  return seen;
}

/// All landmarks of a room, coded ones identified.
inline std::vector<SightedLandmark> sightings_of(Random& random, const Room& room) {
  std::vector<SightedLandmark> seen;
  for (std::size_t i = 0; i < room.map.size(); ++i) {
    seen.push_back(sighting_of(random, room.T_world_camera, room.map[i].T_world_landmark));
    if (!room.map[i].is_black_and_white) seen.back().coded = i;
  }
  return seen;
}

/// As a person moves a sheet: 150 mm along the wall and 8 degrees about the vertical.
inline WorldFromLandmark moved_sheet(const WorldFromLandmark& place, double distance_m = 0.15,
                                     double angle_rad = 8 * kDeg) {
  return {place.rotation * exp_so3({0, 0, angle_rad}), place * Eigen::Vector3d(distance_m, 0, 0)};
}

/// Squared length of the error in units of the answer's own covariance: chi^2 of six freedoms where it is honest.
inline double nees(const WorldPose& pose, const WorldFromCamera& truth) {
  const PoseStep error = step_between(pose.T_world_camera, truth);
  return error.dot(pose.covariance.llt().solve(error));
}

}  // namespace ninedot::test
