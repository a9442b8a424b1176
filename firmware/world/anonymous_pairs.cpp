// Two sheets that hang somewhere have four numbers that no place of the camera and no numbering of their dots changes:
// how far apart they are, how far each lies before the other's plane, and the angle between them. Pairs of the map that
// have these four numbers as a pair of sightings has them, each within its uncertainty, are fitted.
#include <algorithm>
#include <cmath>

#include "world/anonymous.h"
#include "world/sheet_sight.h"

namespace ninedot {
namespace {

/// One in a million true pairs is beyond.
constexpr double kGate_sigmas = 5;
/// A tilt that is less certain says nothing, and its likelihood is no longer normal.
constexpr double kMostTiltSigma_rad = 0.2;
/// Pairs of sightings from which hypotheses start: of the surest four, all with all.
constexpr int kMaxSightedPairs = 6;

/// Two crests of a sighting, as turns of the sheet before the camera.
using Crests = InlineVector<Eigen::Matrix3d, 2>;

Crests crests_of(const Scene& scene, std::size_t sighting) noexcept {
  Crests crests;
  static_cast<void>(crests.try_push_back(scene.own(sighting).T_camera_landmark.rotation));
  if (scene.seen()[sighting].mirror) static_cast<void>(crests.try_push_back(scene.seen()[sighting].mirror->rotation));
  return crests;
}

double angle_rad(const Eigen::Vector3d& a, const Eigen::Vector3d& b) noexcept {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

/// A pair of sightings on its search through the map's pairs.
class PairSearch {
 public:
  PairSearch(const Scene& scene, std::size_t a, std::size_t b) noexcept
      : scene_(scene), a_(a), b_(b), crests_a_(crests_of(scene, a)), crests_b_(crests_of(scene, b)) {
    between_m_ = scene.own(b).T_camera_landmark.translation_m - scene.own(a).T_camera_landmark.translation_m;
    place_sigma_m_ =
        std::hypot(distance_sigma_m(scene, a), distance_sigma_m(scene, b)) + 2 * scene.map().worst_place_sigma_m();
    tilt_sigma_a_rad_ = std::min(tilt_sigma_rad(scene, a), kMostTiltSigma_rad);
    tilt_sigma_b_rad_ = std::min(tilt_sigma_rad(scene, b), kMostTiltSigma_rad);
  }

  std::span<const LandmarkPair> alike() const noexcept {
    const double distance_m = between_m_.norm(), reach_m = kGate_sigmas * place_sigma_m_;
    return scene_.map().pairs_at(distance_m - reach_m, distance_m + reach_m);
  }

  /// The numberings of `a` in which these landmarks can be the pair, a bit each; 0: they can't.
  unsigned turns_as(std::size_t landmark_a, std::size_t landmark_b) const noexcept {
    const WorldFromLandmark& A = scene_.map()[landmark_a].T_world_landmark;
    const WorldFromLandmark& B = scene_.map()[landmark_b].T_world_landmark;
    const Eigen::Vector3d from_a_m = A.rotation.transpose() * (B.translation_m - A.translation_m);
    const double before_b_m = B.rotation.col(1).dot(A.translation_m - B.translation_m);
    const double angle = angle_rad(A.rotation.col(1), B.rotation.col(1));
    unsigned turns = 0;
    for (const Eigen::Matrix3d& a : crests_a_)
      for (const Eigen::Matrix3d& b : crests_b_)
        if (std::abs(b.col(1).dot(-between_m_) - before_b_m) < reach_m(tilt_sigma_b_rad_) &&
            std::abs(angle_rad(a.col(1), b.col(1)) - angle) < kGate_sigmas * (tilt_sigma_a_rad_ + tilt_sigma_b_rad_))
          turns |= turns_of(a.transpose() * between_m_, from_a_m);
    return turns;
  }

  /// Fits the pair in one of those numberings.
  void fit(const Choice& a, std::size_t landmark_b, HypothesisList& list) const noexcept {
    HypothesisList of_a;
    start_alone(scene_, a_, a, of_a);
    unsigned tried = 0;
    for (const WorldHypothesis& alone : of_a) {
      const Eigen::Matrix3d R_camera_landmark =
          alone.T_world_camera.rotation.transpose() * scene_.map()[landmark_b].T_world_landmark.rotation;
      for (const std::size_t turn : turns_for(scene_, b_, R_camera_landmark)) {
        if ((tried >> turn & 1U) != 0) continue;
        tried |= 1U << turn;
        start_with_pair(scene_, a_, a, b_, {landmark_b, turn}, list);
      }
    }
  }

 private:
  double reach_m(double tilt_sigma_rad) const noexcept {
    return kGate_sigmas * std::hypot(place_sigma_m_, tilt_sigma_rad * between_m_.norm());
  }

  /// The other sheet seen from the first, in its axes: as sighted and as the map has it.
  unsigned turns_of(const Eigen::Vector3d& sighted_m, const Eigen::Vector3d& mapped_m) const noexcept {
    const double reach = reach_m(tilt_sigma_a_rad_);
    if (std::abs(sighted_m.y() - mapped_m.y()) > reach) return 0;
    unsigned turns = 0;
    for (std::size_t turn = 0; turn < kRingDotCount; ++turn) {
      const Eigen::Vector3d turned_m = axes_of_turn(turn) * mapped_m;
      if ((sighted_m - turned_m).norm() < reach + kGate_sigmas * place_sigma_m_ && is_likely(turn)) turns |= 1U << turn;
    }
    return turns;
  }

  /// By the camera's roll alone.
  bool is_likely(std::size_t turn) const noexcept {
    const NumberingCosts& costs = scene_.seen()[a_].numbering_costs;
    return costs[turn] < *std::ranges::min_element(costs) + 2 * scene_.options().max_disagreement_chi2;
  }

  const Scene& scene_;
  std::size_t a_, b_;
  Crests crests_a_, crests_b_;
  Eigen::Vector3d between_m_;  // from the P9 of a to that of b, camera axes
  double place_sigma_m_ = 0, tilt_sigma_a_rad_ = 0, tilt_sigma_b_rad_ = 0;
};

struct Allowance {
  int tested = kMaxPairsTested, fitted = kMaxPairsFitted;
};

/// \return  false: not all of the map's pairs were looked at, or there was no room for what they gave
bool search_pair(const Scene& scene, std::size_t a, std::size_t b, Allowance& left, HypothesisList& list) noexcept {
  const PairSearch search(scene, a, b);
  for (const LandmarkPair& pair : search.alike()) {
    for (const bool swapped : {false, true}) {
      const std::size_t landmark_a = swapped ? pair.second : pair.first;
      const std::size_t landmark_b = swapped ? pair.first : pair.second;
      if (!scene.is_believed(landmark_a) || !scene.is_believed(landmark_b)) continue;
      if (--left.tested < 0) return false;
      const unsigned turns = search.turns_as(landmark_a, landmark_b);
      for (std::size_t turn = 0; turn < kRingDotCount; ++turn) {
        if ((turns >> turn & 1U) == 0) continue;
        if (--left.fitted < 0) return false;
        HypothesisList of_pair;
        search.fit({landmark_a, turn}, landmark_b, of_pair);
        for (const WorldHypothesis& hypothesis : of_pair)
          if (!list.try_push_back(hypothesis)) return false;
      }
    }
  }
  return true;
}

}  // namespace

bool start_with_pairs(const Scene& scene, HypothesisList& list) noexcept {
  InlineVector<std::size_t, kMaxSightings> sighted;
  for (const std::size_t i : scene.by_sureness())
    if (scene.is_anonymous(i)) static_cast<void>(sighted.try_push_back(i));
  bool is_complete = true;
  int pairs = 0;
  Allowance left;
  for (std::size_t b = 1; b < sighted.size(); ++b) {
    for (std::size_t a = 0; a < b && pairs < kMaxSightedPairs; ++a) {
      const auto has_both = [&](const WorldHypothesis& h) {
        return h.choices[sighted[a]].is_made() && h.choices[sighted[b]].is_made();
      };
      // As with coded ones: what a majority agrees on can't be outvoted.
      const auto has_majority = [&](const WorldHypothesis& h) { return 2 * h.used > static_cast<int>(sighted.size()); };
      if (std::ranges::any_of(list, has_majority) || std::ranges::any_of(list, has_both)) continue;
      ++pairs;
      is_complete &= search_pair(scene, sighted[a], sighted[b], left, list);
      is_complete &= take_in_anonymous(scene, list);
    }
  }
  return is_complete;
}

}  // namespace ninedot
