#include "world/anonymous.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "base/contract.h"
#include "world/sheet_sight.h"

namespace ninedot {
namespace {

/// Sheets are looked for within so many sigmas of where they are expected: one in a million is beyond.
constexpr double kReach_sigmas = 5;
/// A sheet that hangs no further aside than this was moved and not replaced.
constexpr double kMoved_m = 0.5;

/// How far a landmark may hang from where a place of the camera and a sighting together put it.
double reach_m(const Scene& scene, std::size_t sighting, const PoseCovariance& camera,
               const Eigen::Matrix3d& R_world_camera) noexcept {
  const Eigen::Vector3d& p9 = scene.own(sighting).T_camera_landmark.translation_m;
  Eigen::Matrix3d cross;
  cross << 0, -p9.z(), p9.y(), p9.z(), 0, -p9.x(), -p9.y(), p9.x(), 0;
  Eigen::Matrix<double, 3, 6> J;
  J << Eigen::Matrix3d::Identity(), -R_world_camera * cross;
  const double camera_m = std::sqrt((J * camera * J.transpose()).trace());
  return kReach_sigmas * (camera_m + distance_sigma_m(scene, sighting) + scene.map().worst_place_sigma_m());
}

/// Adds a sighting to one hypothesis as each landmark that it agrees with; the first goes into the hypothesis, further
/// ones are appended as hypotheses of their own.
bool take_in(const Scene& scene, std::size_t sighting, std::size_t at, HypothesisList& list) noexcept {
  const WorldHypothesis before = list[at];
  const PoseCovariance covariance = before.normal.llt().solve(PoseInformation::Identity());
  const Eigen::Matrix3d& R = before.T_world_camera.rotation;
  const Eigen::Vector3d expected_m = before.T_world_camera * scene.own(sighting).T_camera_landmark.translation_m;
  NearbyLandmarks nearby;
  bool is_complete = scene.map().find_nearby(expected_m, reach_m(scene, sighting, covariance, R), nearby);
  bool is_in = false;
  for (const std::uint16_t landmark : nearby) {
    if (!scene.is_believed(landmark) || uses(before, landmark)) continue;
    const Eigen::Matrix3d R_camera_landmark = R.transpose() * scene.map()[landmark].T_world_landmark.rotation;
    for (const std::size_t turn : turns_for(scene, sighting, R_camera_landmark)) {
      WorldHypothesis with = before;
      if (!try_add(scene, sighting, {landmark, turn}, with)) continue;
      if (!is_in)
        list[at] = with;
      else
        is_complete &= list.try_push_back(with);
      is_in = true;
    }
  }
  return is_complete;
}

}  // namespace

bool take_in_anonymous(const Scene& scene, HypothesisList& list) noexcept {
  bool is_complete = true;
  for (const std::size_t i : scene.by_sureness()) {
    if (!scene.is_anonymous(i)) continue;
    const std::size_t hypotheses = list.size();  // those that are appended have this sighting already
    for (std::size_t h = 0; h < hypotheses; ++h)
      if (!list[h].choices[i].is_made()) is_complete &= take_in(scene, i, h, list);
  }
  return is_complete;
}

bool start_near_prior(const Scene& scene, const WorldPrior& prior, HypothesisList& list) noexcept {
  const Eigen::Matrix3d& R = prior.T_world_camera.rotation;
  bool is_complete = true;
  for (const std::size_t i : scene.by_sureness()) {
    if (!scene.is_anonymous(i) ||
        std::ranges::any_of(list, [&](const WorldHypothesis& h) { return h.choices[i].is_made(); }))
      continue;
    const Eigen::Vector3d expected_m = prior.T_world_camera * scene.own(i).T_camera_landmark.translation_m;
    NearbyLandmarks nearby;
    is_complete &= scene.map().find_nearby(expected_m, reach_m(scene, i, prior.covariance, R), nearby);
    HypothesisList of_this;
    for (const std::uint16_t landmark : nearby) {
      if (!scene.is_believed(landmark)) continue;
      const Eigen::Matrix3d R_camera_landmark = R.transpose() * scene.map()[landmark].T_world_landmark.rotation;
      for (const std::size_t turn : turns_for(scene, i, R_camera_landmark)) {
        of_this.clear();
        start_alone(scene, i, {landmark, turn}, of_this);
        for (WorldHypothesis& hypothesis : of_this)
          if (settle(scene, hypothesis) && prior_chi2(prior, hypothesis) <= scene.options().max_disagreement_chi2)
            is_complete &= list.try_push_back(hypothesis);
      }
    }
    is_complete &= take_in_anonymous(scene, list);
  }
  return is_complete;
}

bool start_with_the_only_one(const Scene& scene, HypothesisList& list) noexcept {
  EXPECTS(scene.map().anonymous().size() == 1);
  const std::size_t landmark = scene.map().anonymous().front();
  if (!scene.is_believed(landmark)) return true;
  bool is_complete = true;
  for (const std::size_t i : scene.by_sureness()) {
    if (!scene.is_anonymous(i)) continue;
    HypothesisList of_this;
    for (std::size_t turn = 0; turn < kRingDotCount; ++turn) start_alone(scene, i, {landmark, turn}, of_this);
    // Of eight numberings most are out of the question.
    for (WorldHypothesis& hypothesis : of_this) static_cast<void>(settle(scene, hypothesis));
    const double best = std::ranges::min_element(of_this, {}, &WorldHypothesis::cost)->cost;
    for (const WorldHypothesis& hypothesis : of_this)
      if (hypothesis.cost < best + 2 * scene.options().max_disagreement_chi2)
        is_complete &= list.try_push_back(hypothesis);
  }
  return is_complete;
}

Choice nearest_unseen(const Scene& scene, std::size_t sighting, const WorldHypothesis& hypothesis) noexcept {
  const WorldFromCamera& T = hypothesis.T_world_camera;
  const Eigen::Vector3d seen_m = T * scene.own(sighting).T_camera_landmark.translation_m;
  NearbyLandmarks nearby;
  scene.map().find_nearby(seen_m, kMoved_m, nearby);
  Choice nearest;
  double nearest_m = kMoved_m;
  for (const std::uint16_t landmark : nearby) {
    const WorldFromLandmark& place = scene.map()[landmark].T_world_landmark;
    const double distance_m = (place.translation_m - seen_m).norm();
    const auto turns = turns_for(scene, sighting, T.rotation.transpose() * place.rotation);
    if (distance_m > nearest_m || turns.empty() || uses(hypothesis, landmark)) continue;
    nearest = {landmark, turns[0]};
    nearest_m = distance_m;
  }
  return nearest;
}

}  // namespace ninedot
