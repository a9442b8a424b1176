#include "world/sheet_sight.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>

namespace ninedot {
namespace {

constexpr double kTurn_rad = 2 * std::numbers::pi / kRingDotCount;

/// Normals that differ by more than 60 degrees are not those of one sheet, however small it is seen.
constexpr double kLeastNormalCosine = 0.5;

}  // namespace

double distance_sigma_m(const Scene& scene, std::size_t sighting) noexcept {
  const OwnFit& own = scene.own(sighting);
  // Only the part of the camera's step that lies along the line of sight: across it, position trades with tilt.
  PoseStep along = PoseStep::Zero();
  along.head<3>() = (own.T_camera_landmark.rotation.transpose() * own.T_camera_landmark.translation_m).normalized();
  const double model_m = scene.options().unexplained_share * own.T_camera_landmark.translation_m.norm();
  return std::hypot(std::sqrt(along.dot(own.normal.llt().solve(along))), model_m);
}

double tilt_sigma_rad(const Scene& scene, std::size_t sighting) noexcept {
  const PoseCovariance own = scene.own(sighting).normal.llt().solve(PoseInformation::Identity());
  return std::sqrt(own.bottomRightCorner<3, 3>().trace());
}

InlineVector<std::size_t, 2> turns_for(const Scene& scene, std::size_t sighting,
                                       const Eigen::Matrix3d& R_camera_landmark) noexcept {
  InlineVector<std::size_t, 2> turns;
  const Eigen::Matrix3d M = scene.own(sighting).T_camera_landmark.rotation.transpose() * R_camera_landmark;
  const std::optional<CameraFromLandmark>& mirror = scene.seen()[sighting].mirror;
  const double mirror_cosine = mirror ? mirror->rotation.col(1).dot(R_camera_landmark.col(1)) : -1;
  if (std::max(M(1, 1), mirror_cosine) < kLeastNormalCosine) return turns;
  const double eighths = std::atan2(M(2, 0) - M(0, 2), M(0, 0) + M(2, 2)) / kTurn_rad;
  const auto numbered = [](double turn) { return static_cast<std::size_t>(std::lround(turn) + 8) % kRingDotCount; };
  static_cast<void>(turns.try_push_back(numbered(eighths)));
  const double beyond = eighths - std::round(eighths);
  if (std::abs(beyond) > 0.3) static_cast<void>(turns.try_push_back(numbered(eighths + (beyond > 0 ? 0.5 : -0.5))));
  return turns;
}

}  // namespace ninedot
