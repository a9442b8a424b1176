#include "world/scene.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <numbers>

#include "base/contract.h"

namespace ninedot {
namespace {

/// Nearer to the minimum of chi^2 than this, a sigma, a step's own forecast of the minimum does.
constexpr double kNearOptimum_chi2 = 1;
/// A sighting's own pose is the best for its grey levels, and that of its rays is a little aside: one step or two.
constexpr int kMaxSteps = 4;
/// Of a sheet in the room, each of which noise costs a sigma squared on average.
constexpr double kFreedoms = 6;
/// Where a sheet hangs whose code was misread: as likely here as anywhere within a metre and a radian of here, which is
/// more than the room says of it.
constexpr double kElsewhere_m3_rad3 = 1;

OwnFit fit_alone(const LandmarkSighting& sighting, const LandmarkGeometry& landmark) noexcept {
  OwnFit own;
  own.sureness = -std::numeric_limits<double>::infinity();
  // The landmark's own frame does for the world here: all that is asked is how well the sighting fits itself.
  const WorldFromLandmark here;
  const Transform<frame::Landmark, frame::Camera> T_landmark_camera = sighting.T_camera_landmark.inverse();
  WorldFromCamera at{T_landmark_camera.rotation, T_landmark_camera.translation_m};
  for (int i = 0; i < kMaxSteps; ++i) {
    const SightingFit fit = fit_of_sighting(sighting, here, at, landmark);
    const Eigen::LLT<PoseInformation> solver(fit.normal);
    if (!std::isfinite(fit.chi2) || fit.dots < 3 || solver.info() != Eigen::Success) return own;
    const PoseStep step = -solver.solve(fit.gradient);
    const double drop = -step.dot(fit.gradient);
    at = moved_by(at, step);
    if (drop > kNearOptimum_chi2) continue;
    own.T_camera_landmark = {at.rotation.transpose(), -(at.rotation.transpose() * at.translation_m)};
    own.chi2 = fit.chi2 - drop;
    own.normal = fit.normal;
    own.sureness = 2 * solver.matrixLLT().diagonal().array().log().sum();
    return own;
  }
  // Where both crests are nearly one, steps lead astray: damped ones don't.
  const JointMember alone{.sighting = &sighting, .T_world_landmark = here};
  JointFit fit;
  fit_jointly({&alone, 1}, {T_landmark_camera.rotation, T_landmark_camera.translation_m}, landmark, fit);
  if (!fit.is_determined()) return own;
  at = fit.T_world_camera;
  own.T_camera_landmark = {at.rotation.transpose(), -(at.rotation.transpose() * at.translation_m)};
  own.chi2 = fit.sum.chi2;
  own.normal = fit.sum.normal;
  own.sureness = std::log(fit.sum.normal.determinant());
  return own;
}

}  // namespace

Scene::Scene(std::span<const SightedLandmark> seen, const PreparedMap& map, const MovedLandmarks& moved,
             const LandmarkGeometry& landmark, const WorldOptions& options, const WorldPrior* prior) noexcept
    : seen_(seen), map_(map), moved_(moved), landmark_(landmark), options_(options), prior_(prior) {
  EXPECTS(seen.size() <= kMaxSightings);
  for (std::size_t i = 0; i < seen.size(); ++i) {
    own_[i] = fit_alone(seen[i].sighting, landmark);
    if (determines_pose(i)) static_cast<void>(by_sureness_.try_push_back(i));
  }
  std::ranges::sort(by_sureness_, std::greater{}, [this](std::size_t i) { return own_[i].sureness; });
  for (std::size_t i = 0; i < seen.size(); ++i) leave_out_cost_[i] = cost_of_leaving_out(i);
}

bool Scene::is_known(std::size_t sighting) const noexcept {
  const std::optional<std::size_t>& coded = seen_[sighting].coded;
  return coded && map_[*coded].has_place && !moved_.is_moved(*coded);
}

bool Scene::is_known_moved(std::size_t sighting) const noexcept {
  const std::optional<std::size_t>& coded = seen_[sighting].coded;
  return coded && map_[*coded].has_place && moved_.is_moved(*coded);
}

bool Scene::is_anonymous(std::size_t sighting) const noexcept {
  return !seen_[sighting].coded && !map_.anonymous().empty();
}

double Scene::cost_of_leaving_out(std::size_t sighting) const noexcept {
  if (!determines_pose(sighting)) return 0;
  if (is_anonymous(sighting)) return options_.max_disagreement_chi2;
  if (!is_known(sighting)) return 0;
  // Without a track it pays at least what the right one's noise costs on average.
  const double chance = prior_ != nullptr ? cost_of_chance(sighting, *prior_) : kFreedoms;
  const double elsewhere = -2 * std::log(seen_[sighting].others_odds) + chance;
  return std::min(options_.max_disagreement_chi2, elsewhere);
}

/// A sheet that hangs elsewhere meets by chance alone the place that a track foretells: the less likely, the better
/// that is known, 1 over (the normalising constant of the Gaussian) of the volume where it could be.
double Scene::cost_of_chance(std::size_t sighting, const WorldPrior& prior) const noexcept {
  PoseCovariance own = own_[sighting].normal.llt().solve(PoseInformation::Identity());
  const Eigen::Matrix3d& R = map_[*seen_[sighting].coded].T_world_landmark.rotation;
  own.topLeftCorner<3, 3>() = (R * own.topLeftCorner<3, 3>() * R.transpose()).eval();
  own.topRightCorner<3, 3>() = (R * own.topRightCorner<3, 3>()).eval();
  own.bottomLeftCorner<3, 3>() = own.topRightCorner<3, 3>().transpose();
  const Eigen::LLT<PoseCovariance> spread(prior.covariance + own);
  if (spread.info() != Eigen::Success) return kFreedoms;
  const double log_det = 2 * spread.matrixLLT().diagonal().array().log().sum();
  const double log_volume = kFreedoms * std::log(2 * std::numbers::pi) + log_det - 2 * std::log(kElsewhere_m3_rad3);
  return std::max(kFreedoms, -log_volume);
}

double Scene::numbering_cost(std::size_t sighting, const Choice& choice) const noexcept {
  // The costs are of a sheet that hangs upright; of one that does not they say nothing.
  if (seen_[sighting].coded || !map_[choice.landmark].is_upright()) return 0;
  return seen_[sighting].numbering_costs[choice.turn];
}

JointMember Scene::member(std::size_t sighting, const Choice& choice) const noexcept {
  const PlacedLandmark& placed = map_[choice.landmark];
  JointMember member{.sighting = &seen_[sighting].sighting, .T_world_landmark = placed.T_world_landmark};
  if (choice.turn != 0) member.T_world_landmark.rotation *= axes_of_turn(choice.turn).transpose();
  if (!placed.covariance.isZero(0)) member.place_covariance = &placed.covariance;
  return member;
}

WorldFromCamera Scene::camera_by(const CameraFromLandmark& T_camera_landmark, const Choice& choice) const noexcept {
  WorldFromLandmark place = map_[choice.landmark].T_world_landmark;
  if (choice.turn != 0) place.rotation *= axes_of_turn(choice.turn).transpose();
  return place * T_camera_landmark.inverse();
}

Eigen::Matrix3d axes_of_turn(std::size_t turn) noexcept {
  // Counted from P1 the dots go clockwise: from -Z towards +X, which is a turn about -Y.
  return exp_so3(-2 * std::numbers::pi / kRingDotCount * static_cast<double>(turn) * Eigen::Vector3d::UnitY());
}

}  // namespace ninedot
