#pragma once
/// A room with landmarks, ways through it and what a camera sees on them, for tests of the filter. Moves, projects and
/// makes noise by itself: of what it tests it shares the landmark's geometry alone.
#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "base/units.h"
#include "pose/mirror_image.h"
#include "tests/support/random.h"
#include "track/pose_filter.h"
#include "world/landmark_map.h"

namespace ninedot::test {

inline constexpr double kFocal_px = 600, kRate_hz = 35;
inline const LandmarkGeometry kSheet{};

/// Where the camera is at a time [s].
using Way = std::function<WorldFromCamera(double)>;

/// Yaw 0 looks along +X, pitch is positive upwards.
inline WorldFromCamera camera_at(const Eigen::Vector3d& position_m, double yaw_rad, double pitch_rad, double roll_rad) {
  const Eigen::Vector3d ahead(std::cos(yaw_rad) * std::cos(pitch_rad), std::sin(yaw_rad) * std::cos(pitch_rad),
                              std::sin(pitch_rad));
  const Eigen::Vector3d right = ahead.cross(Eigen::Vector3d::UnitZ()).normalized(), down = ahead.cross(right);
  WorldFromCamera T;
  T.rotation << std::cos(roll_rad) * right + std::sin(roll_rad) * down,
      -std::sin(roll_rad) * right + std::cos(roll_rad) * down, ahead;
  T.translation_m = position_m;
  return T;
}

/// Eight landmarks on the four walls of a room of 8 m by 6 m.
inline LandmarkMap room_map() {
  const double k = kRadPerDeg;
  return LandmarkMap({{1, "", place_upright({4, -1.5, 1.3}, 90 * k)},
                      {2, "", place_upright({4, 0.9, 1.6}, 90 * k)},
                      {3, "", place_upright({2.3, 3, 1.3}, 180 * k)},
                      {4, "", place_upright({0.3, 3, 1.5}, 180 * k)},
                      {5, "", place_upright({4, -0.4, 1.2}, 90 * k)},
                      {6, "", place_upright({3.3, -3, 1.4}, 0)},
                      {7, "", place_upright({4, 2.0, 1.2}, 90 * k)},
                      {8, "", place_upright({3.6, 3, 1.6}, 180 * k)}});
}
/// One landmark that looks along -X from x = 4 m.
inline LandmarkMap wall_map() { return LandmarkMap({{1, "", place_upright({4, 0, 1.4}, 90 * kRadPerDeg)}}); }

/// 1 m/s, weaving by 0.35 m, the head swinging by 35 degrees at 1.3 rad/s, and a wobble at 2 to 3 rad/s.
inline Way walk(double phase_rad) {
  return [phase_rad](double t) {
    const double weave = 0.9 * t + phase_rad;
    const Eigen::Vector3d position(-2.4 + t, -0.6 + 0.35 * std::sin(weave), 1 + 0.004 * std::sin(2.6 * t));
    const double heading = std::atan2(0.35 * 0.9 * std::cos(weave), 1.0);
    return camera_at(position, heading + 35 * kRadPerDeg * std::sin(1.3 * t + phase_rad),
                     0.09 + 0.004 * std::sin(1.7 * t), 0.006 * std::sin(2.1 * t));
  };
}
/// Round the room's middle at 1.2 m and 100 degrees per second, looking across it, ahead and back by turns: 4 m/s^2 and
/// up to 290 degrees/s^2, of which the filter's options let expect a tenth and a fifth.
inline Way whirl(double phase_rad) {
  return [phase_rad](double t) {
    const double round = 1.75 * t + phase_rad;
    return camera_at({-1.2 * std::cos(round), -1.2 * std::sin(round), 1.25 + 0.1 * std::sin(3 * round)},
                     round + 0.3 * std::sin(2.3 * round), 0.06 + 0.05 * std::sin(1.7 * t), 0.06 * std::sin(2.6 * t));
  };
}
/// Slowly across the normal of wall_map's landmark, from 3 m to 4.5 m.
inline Way flip(double duration_s, double phase_rad) {
  return [=](double t) {
    const double s = t / duration_s, x = 4 - 3 - 1.5 * s, y = 0.5 * (2 * s - 1);
    const double wobble[] = {std::sin(2.1 * t + phase_rad), std::sin(1.7 * t + phase_rad),
                             std::sin(2.6 * t + phase_rad)};
    return camera_at({x, y, 1.395 + 0.008 * wobble[2]}, std::atan2(-y, 4 - x) + 0.004 * wobble[0], 0.003 * wobble[1],
                     0.01 * wobble[2]);
  };
}

struct Noise {
  double ray_px = 0.05;     ///< 1-sigma of each dot and axis
  double stated_px = 0.05;  ///< what the sightings say of it
  double common = 0;        ///< share of that variance that lasts [1]
  double lasts_s = 1;       ///< for about this long
};

/// Takes pictures on a way.
class Camera {
 public:
  Camera(const LandmarkMap& map, const Noise& noise, std::uint64_t seed)
      : map_(map), noise_(noise), random_(seed), common_(map.landmarks().size()) {
    for (auto& dots : common_)
      for (Eigen::Vector2d& dot : dots) dot = normal();
  }

  /// What is wholly in the picture, at most 6 m away, seen by no more than 75 degrees from aside.
  std::vector<LandmarkSighting> see(const WorldFromCamera& T_world_camera, double dt_s) {
    std::vector<LandmarkSighting> seen;
    const double kept = std::exp(-dt_s / noise_.lasts_s), sigma = noise_.ray_px / kFocal_px;
    for (std::size_t i = 0; i < common_.size(); ++i) {
      const MappedLandmark& mapped = map_.landmarks()[i];
      LandmarkSighting sighting{
          .id = mapped.id, .T_camera_landmark = T_world_camera.inverse() * mapped.T_world_landmark, .dots = {}};
      const Eigen::Vector3d to_camera = sighting.T_camera_landmark.inverse().translation_m;
      bool whole = to_camera.norm() < 6 && to_camera.y() > std::cos(75 * kRadPerDeg) * to_camera.norm();
      for (std::size_t dot = 0; dot < kDotCount; ++dot) {
        const Eigen::Vector2d c = kSheet.centre_m(dot);
        const Eigen::Vector3d p = sighting.T_camera_landmark * Eigen::Vector3d(c.x(), 0, c.y());
        Eigen::Vector2d& common = common_[i][dot];
        common = kept * common + std::sqrt(1 - kept * kept) * normal();
        if (!(p.z() > 0.1 && std::abs(p.x()) < 0.53 * p.z() && std::abs(p.y()) < 0.4 * p.z())) whole = false;
        sighting.dots[dot].ray = Eigen::Vector2d(p.x() / p.z(), p.y() / p.z()) +
                                 sigma * (std::sqrt(1 - noise_.common) * normal() + std::sqrt(noise_.common) * common);
        sighting.dots[dot].information = Eigen::Matrix2d::Identity() * std::pow(kFocal_px / noise_.stated_px, 2);
      }
      if (whole) seen.push_back(sighting);
    }
    return seen;
  }

 private:
  Eigen::Vector2d normal() {
    const double x = random_.normal();
    return {x, random_.normal()};
  }

  const LandmarkMap& map_;
  Noise noise_;
  Random random_;
  std::vector<std::array<Eigen::Vector2d, kDotCount>> common_;  // of unit variance; by place in the map
};

/// The sightings with the places that the map has for them; it must outlive them, and so must the sightings.
inline std::vector<JointMember> members_of(const std::vector<LandmarkSighting>& sightings, const LandmarkMap& map) {
  std::vector<JointMember> members;
  for (const LandmarkSighting& sighting : sightings) {
    const MappedLandmark& mapped = *map.find(sighting.id);
    members.push_back({&sighting, mapped.T_world_landmark, mapped.covariance.isZero(0) ? nullptr : &mapped.covariance});
  }
  return members;
}

/// The best place of the camera near `start`, by the picture alone.
inline WorldReading most_likely(const std::vector<LandmarkSighting>& sightings, const LandmarkMap& map,
                                const WorldFromCamera& start) {
  const auto fit_at = [&](const WorldFromCamera& T) {
    SightingFit fit;
    for (const LandmarkSighting& sighting : sightings)
      fit += fit_of_sighting(sighting, map.find(sighting.id)->T_world_landmark, T, kSheet);
    return fit;
  };
  WorldReading best{start};
  SightingFit fit = fit_at(start);
  double damping = 1e-6;
  for (int i = 0; i < 60; ++i) {
    PoseInformation damped = fit.normal;
    damped.diagonal() *= 1 + damping;
    const PoseStep step = -damped.ldlt().solve(fit.gradient);
    const SightingFit next = fit_at(moved_by(best.T_world_camera, step));
    damping = next.chi2 <= fit.chi2 ? damping / 10 : damping * 30;
    if (next.chi2 > fit.chi2) continue;
    best.T_world_camera = moved_by(best.T_world_camera, step);
    fit = next;
    if (step.dot(fit.normal * step) < 1e-10) break;
  }
  best.chi2_above = fit.chi2;
  return best;
}

/// The crests of one picture alone, best first: from the truth, and from the mirror images of its landmarks.
inline std::vector<WorldReading> readings_of(const std::vector<LandmarkSighting>& sightings, const LandmarkMap& map,
                                             const WorldFromCamera& truth) {
  std::vector<WorldReading> readings;
  if (sightings.empty()) return readings;
  const auto add = [&](const WorldFromCamera& start) {
    const WorldReading found = most_likely(sightings, map, start);
    for (const WorldReading& known : readings)
      if (step_between(known.T_world_camera, found.T_world_camera).norm() < 1e-3) return;
    readings.push_back(found);
  };
  add(truth);
  for (const LandmarkSighting& sighting : sightings) {
    const WorldFromLandmark& place = map.find(sighting.id)->T_world_landmark;
    add(place * mirror_image(readings[0].T_world_camera.inverse() * place, kSheet).inverse());
  }
  std::sort(readings.begin(), readings.end(),
            [](const WorldReading& a, const WorldReading& b) { return a.chi2_above < b.chi2_above; });
  const double best = readings[0].chi2_above;
  for (WorldReading& reading : readings) reading.chi2_above -= best;
  return readings;
}

}  // namespace ninedot::test
