#include "hall.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "mapping/place_vote.h"
#include "tests/support/random.h"

namespace ninedot::test {
namespace {

constexpr double kLength_m = 30, kWidth_m = 5, kPitch_m = 9, kSpacing_m = 1.8;
constexpr double kFocal_px = 420, kHalfWidth_px = 310, kHalfHeight_px = 230;
constexpr double kFarthest_m = 11, kSteepest_rad = 72 * std::numbers::pi / 180;
const LandmarkGeometry kSheet{};

/// Inside of a corridor or of the two that join their ends.
bool is_free(double x, double y, std::size_t corridors) {
  const double half = kWidth_m / 2 + 1e-6, last = kPitch_m * static_cast<double>(corridors - 1);
  if (y < -half || y > last + half || x < -half || x > kLength_m + half) return false;
  return x < half || x > kLength_m - half || std::abs(y - kPitch_m * std::round(y / kPitch_m)) < half;
}

bool sees(const Eigen::Vector3d& from, const Eigen::Vector3d& to, std::size_t corridors) {
  const int steps = 1 + static_cast<int>((to - from).norm() / 0.2);
  for (int i = 0; i <= steps; ++i) {
    const Eigen::Vector3d p = from + (to - from) * i / steps;
    if (!is_free(p.x(), p.y(), corridors)) return false;
  }
  return true;
}

/// A sheet on a wall, a little askew as sheets are.
WorldFromLandmark hung(double x, double y, double heading, Random& random) {
  const Eigen::Vector3d askew(0.01 * random.normal(), 0.01 * random.normal(), 0.005 * random.normal());
  return {exp_so3(heading * Eigen::Vector3d::UnitZ()) * exp_so3(askew), {x, y, random.uniform(1.1, 1.8)}};
}

/// Heading 0 looks along +Y.
constexpr double kToPlusY = 0, kToMinusY = std::numbers::pi, kToPlusX = -std::numbers::pi / 2,
                 kToMinusX = std::numbers::pi / 2;

std::vector<MappedLandmark> hang_landmarks(std::size_t count, std::size_t& corridors, Random& random) {
  std::vector<MappedLandmark> all;
  const auto add = [&](double x, double y, double heading) {
    if (all.size() < count)
      all.push_back({static_cast<std::uint16_t>(all.size() + 1), "", hung(x, y, heading, random)});
  };
  for (corridors = 0; all.size() < count; ++corridors) {
    const double y = kPitch_m * static_cast<double>(corridors);
    for (double x = kWidth_m; x < kLength_m - kWidth_m / 2; x += kSpacing_m) {
      add(x + random.uniform(-0.4, 0), y - kWidth_m / 2, kToPlusY);
      add(x + random.uniform(-0.4, 0), y + kWidth_m / 2, kToMinusY);
    }
    for (double dy = -1; dy < kPitch_m - 1; dy += kSpacing_m) {
      add(-kWidth_m / 2, y + dy, kToPlusX);
      add(kLength_m + kWidth_m / 2, y + dy, kToMinusX);
    }
  }
  return all;
}

/// Up and down through all corridors, then along both ends, and home through the first one: loops that close.
std::vector<Eigen::Vector2d> corners_of_way(std::size_t corridors) {
  std::vector<Eigen::Vector2d> corners{{0, 0}};
  for (std::size_t i = 0; i < corridors; ++i) {
    const double y = kPitch_m * static_cast<double>(i), x = i % 2 == 0 ? kLength_m : 0;
    corners.emplace_back(x, y);
    if (i + 1 < corridors) corners.emplace_back(x, y + kPitch_m);
  }
  const double last = kPitch_m * static_cast<double>(corridors - 1), x = corridors % 2 == 0 ? 0 : kLength_m;
  corners.emplace_back(x, 0);
  corners.emplace_back(kLength_m - x, 0);
  corners.emplace_back(kLength_m - x, last);
  corners.emplace_back(x, last);
  return corners;
}

WorldFromCamera camera_at(const Eigen::Vector3d& position, double yaw, double pitch, double roll) {
  const Eigen::Vector3d forward(std::cos(yaw) * std::cos(pitch), std::sin(yaw) * std::cos(pitch), std::sin(pitch));
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d::UnitZ()).normalized();
  Eigen::Matrix3d R;
  R << right, forward.cross(right), forward;
  return {R * exp_so3({0, 0, roll}), position};
}

/// A bearing turned by the mirror's rule: the sheet's normal on the other side of the line of sight.
CameraFromLandmark mirrored(const CameraFromLandmark& T) {
  const Eigen::Vector3d sight = T.translation_m.normalized();
  const Eigen::Vector3d normal = T.rotation.col(1);
  const Eigen::Vector3d axis = normal.cross(-sight);
  const double angle = std::atan2(axis.norm(), normal.dot(-sight));
  if (axis.norm() < 1e-6) return T;
  return {exp_so3(2 * angle * axis.normalized()) * T.rotation, T.translation_m};
}

class Camera {
 public:
  Camera(const HallOptions& options, std::size_t corridors, Random& random)
      : options_(options), corridors_(corridors), random_(random) {}

  void add_sighting(const MappedLandmark& landmark, const WorldFromLandmark& place, const WorldFromCamera& camera,
                    std::vector<LandmarkSighting>& list) {
    CameraFromLandmark T = camera.inverse() * place;
    const double distance_m = T.translation_m.norm();
    const Eigen::Vector3d to_camera = camera.translation_m - place.translation_m;
    if (T.translation_m.z() < 0.5 || distance_m > kFarthest_m ||
        to_camera.normalized().dot(place.rotation.col(1)) < std::cos(kSteepest_rad) ||
        std::abs(T.translation_m.x() / T.translation_m.z()) > kHalfWidth_px / kFocal_px ||
        std::abs(T.translation_m.y() / T.translation_m.z()) > kHalfHeight_px / kFocal_px ||
        !sees(camera.translation_m, place.translation_m + 0.01 * place.rotation.col(1), corridors_))
      return;
    LandmarkSighting seen;
    seen.id = landmark.id;
    if (options_.turn_sigma_rad > 0 && landmark.id % 2 == 0) {
      seen.turn_sigma_rad = options_.turn_sigma_rad;
      const Eigen::Matrix3d turn =
          exp_so3(options_.turn_sigma_rad * Eigen::Vector3d(random_.normal(), random_.normal(), random_.normal()));
      T = {turn * T.rotation, turn * T.translation_m};
    }
    seen.T_camera_landmark = random_.uniform(0, 1) < options_.mirrored ? mirrored(T) : T;
    for (std::size_t dot = 0; dot < kDotCount; ++dot) {
      const Eigen::Vector2d on_sheet_m = kSheet.centre_m(dot);
      // A disc's middle from its edge's pixels: noise 2 at contrast 110, over half of its circumference per axis.
      const double radius_px = kFocal_px * kSheet.radius_m(dot) / T.translation_m.z();
      const double sigma = 2.0 / 110 / std::sqrt(std::numbers::pi * radius_px) / kFocal_px;
      const Eigen::Rotation2Dd turned(random_.uniform(0, std::numbers::pi));
      const Eigen::Vector2d sigmas(sigma, 1.5 * sigma);
      const Eigen::Vector2d noise(sigmas.x() * random_.normal(), sigmas.y() * random_.normal());
      seen.dots[dot].ray =
          (T * Eigen::Vector3d(on_sheet_m.x(), 0, on_sheet_m.y())).hnormalized() + options_.noise * (turned * noise);
      seen.dots[dot].information = turned.toRotationMatrix() * sigmas.cwiseAbs2().cwiseInverse().asDiagonal() *
                                   turned.toRotationMatrix().transpose();
    }
    list.push_back(seen);
  }

 private:
  const HallOptions& options_;
  const std::size_t corridors_;
  Random& random_;
};

}  // namespace

std::size_t Hall::sightings() const {
  std::size_t count = 0;
  for (const RecordedSightings& frame : frames) count += frame.list.size();
  return count;
}

LandmarkMap Hall::known(std::uint16_t origin) const {
  std::vector<MappedLandmark> landmarks = truth;
  for (MappedLandmark& landmark : landmarks) {
    if (landmark.id == origin) continue;
    landmark.has_place = false;
    landmark.T_world_landmark = {};
  }
  return LandmarkMap(landmarks);
}

Hall make_hall(const HallOptions& options) {
  Random random(options.seed);
  Hall hall;
  std::size_t corridors = 0;
  hall.truth = hang_landmarks(options.landmarks, corridors, random);
  const std::vector<Eigen::Vector2d> corners = corners_of_way(corridors);
  double total_m = 0;
  for (std::size_t i = 1; i < corners.size(); ++i) total_m += (corners[i] - corners[i - 1]).norm();
  Camera camera(options, corridors, random);
  std::size_t leg = 1;
  double before_leg_m = 0;
  for (std::size_t f = 0; f < options.frames; ++f) {
    const double way_m = total_m * static_cast<double>(f) / static_cast<double>(options.frames);
    while (way_m > before_leg_m + (corners[leg] - corners[leg - 1]).norm())
      before_leg_m += (corners[leg] - corners[leg - 1]).norm(), ++leg;
    const Eigen::Vector2d along = (corners[leg] - corners[leg - 1]).normalized();
    const Eigen::Vector2d at = corners[leg - 1] + along * (way_m - before_leg_m);
    const double yaw = std::atan2(along.y(), along.x()) + 0.3 * std::sin(0.8 * way_m) +
                       0.75 * (static_cast<double>(f % 3) - 1);  // to the left, ahead, to the right
    const WorldFromCamera T_world_camera = camera_at({at.x() - 0.8 * along.x(), at.y() - 0.8 * along.y(), 1.2}, yaw,
                                                     0.05 * random.normal(), 0.03 * random.normal());
    RecordedSightings frame{0, f, MonoTime{}, {}};
    const bool is_late = static_cast<double>(f) >= (1 - options.moved_share) * static_cast<double>(options.frames);
    for (const MappedLandmark& landmark : hall.truth) {
      WorldFromLandmark place = landmark.T_world_landmark;
      if (is_late && landmark.id == options.moved_id) place.translation_m += 0.15 * place.rotation.col(0);
      camera.add_sighting(landmark, place, T_world_camera, frame.list);
    }
    for (LandmarkSighting& seen : frame.list)
      if (random.uniform(0, 1) < options.wrong_identities)
        seen.id = static_cast<std::uint16_t>(1 + random.bits() % options.landmarks);
    hall.frames.push_back(frame);
  }
  return hall;
}

MapScore score(const BuiltMap& map, std::span<const MappedLandmark> truth, std::uint16_t origin) {
  MapScore result;
  double squares_m2 = 0, squares_rad2 = 0, axes = 0, whole = 0;
  for (const MappedLandmark& placed : map.placed) {
    if (placed.id == origin) continue;
    const PlaceStep error = step_between(placed.T_world_landmark, truth[placed.id - 1U].T_world_landmark);
    ++result.placed;
    squares_m2 += error.head<3>().squaredNorm();
    squares_rad2 += error.tail<3>().squaredNorm();
    result.worst_m = std::max(result.worst_m, error.head<3>().norm());
    axes += error.cwiseAbs2().cwiseQuotient(placed.covariance.diagonal()).sum() / 6;
    whole += error.dot(placed.covariance.inverse() * error) / 6;
  }
  const auto count = static_cast<double>(std::max<std::size_t>(1, result.placed));
  result.rms_m = std::sqrt(squares_m2 / count);
  result.rms_rad = std::sqrt(squares_rad2 / count);
  result.axes = std::sqrt(axes / count);
  result.whole = std::sqrt(whole / count);
  return result;
}

}  // namespace ninedot::test
