#include "world/world_solver.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/contract.h"
#include "world/anonymous.h"
#include "world/contested_track.h"

namespace ninedot {
namespace {

/// Pairs of sightings that are asked whether they agree, in one frame: with 16 in view the seven surest, all with all.
/// A pair that agrees takes all others in, so that a usual frame asks one; only landmarks that moved make it ask more.
constexpr int kMaxPairs = 21;

/// Where a contested track decides, each frame weighs the same evidence anew, and the luckiest of many must not name a
/// landmark for good: only odds so far below those of an answer do. [1]
constexpr double kSure = 0.01;

/// Odds that colours leave: of large dots they are 1e-9 and less.
constexpr double kBeyondDoubt = 1e-6;

Choice coded_choice(const Scene& scene, std::size_t sighting) noexcept { return {*scene.seen()[sighting].coded}; }

/// Whether some hypothesis has two sightings, or one, in use.
bool is_covered(const HypothesisList& list, std::size_t a, std::size_t b) noexcept {
  return std::ranges::any_of(
      list, [&](const WorldHypothesis& h) { return h.choices[a].is_made() && h.choices[b].is_made(); });
}

int most_used(const HypothesisList& list) noexcept {
  int most = 0;
  for (const WorldHypothesis& hypothesis : list) most = std::max(most, hypothesis.used);
  return most;
}

/// Places that a track does not foretell are out of the question.
bool is_known_by_track(const Scene& scene, const HypothesisList& list) noexcept {
  const WorldPrior* prior = scene.prior();
  if (is_track_contested(scene, list)) prior = prior->without;
  return prior != nullptr && prior->ambiguity <= scene.options().max_ambiguity;
}

/// By a track, and by what was known before it stood on one landmark alone.
bool start_near_priors(const Scene& scene, HypothesisList& list) noexcept {
  if (scene.prior() == nullptr) return true;
  bool is_complete = start_near_prior(scene, *scene.prior(), list);
  if (is_track_contested(scene, list) && scene.prior()->without != nullptr)
    is_complete &= start_near_prior(scene, *scene.prior()->without, list);
  return is_complete;
}

/// Settles all, and drops what is none.
void settle_all(const Scene& scene, HypothesisList& list) noexcept {
  std::size_t kept = 0;
  for (WorldHypothesis& hypothesis : list)
    if (settle(scene, hypothesis)) list[kept++] = hypothesis;
  list.truncate(kept);
}

/// A landmark in dispute that is seen without any that could contradict it: odds that it is the one which was moved,
/// against that it is not. Where nothing else is known, it is as likely as the other one. 0: it is in no dispute.
double odds_of_dispute(const Scene& scene, const HypothesisList& list) noexcept {
  const WorldHypothesis& best = list[0];
  const auto known = [&](std::size_t i) { return scene.is_known(i); };
  if (best.used != 1 || std::ranges::count_if(scene.by_sureness(), known) != 1) return 0;
  const std::size_t lone = *std::ranges::find_if(scene.by_sureness(), known);
  if (!best.choices[lone].is_made() || !scene.is_disputed(best.choices[lone].landmark)) return 0;
  const WorldPrior* prior = is_track_contested(scene, list) ? scene.prior()->without : scene.prior();
  if (prior == nullptr) return 1;
  const double here = cost_by_prior(scene, *prior, prior_chi2(*prior, best));
  return std::exp((here - cost_by_prior(scene, *prior, scene.cost_of_chance(lone, *prior))) / 2);
}

struct Odds {
  double others = 0;  ///< of all other places than the likeliest
  double astray = 0;  ///< of those the odds that all hangs elsewhere
};

/// The likeliest first.
Odds rank(const Scene& scene, HypothesisList& list) noexcept {
  std::ranges::sort(list, {}, &WorldHypothesis::cost);
  const WorldHypothesis& best = list[0];
  double others = 0, astray = 0;
  for (std::size_t i = 1; i < list.size(); ++i)
    if (!is_same_place(best, list[i].T_world_camera)) others += std::exp((best.cost - list[i].cost) / 2);
  // A track that contradicts all that is seen may be right: then all of it hangs elsewhere.
  if (scene.prior() != nullptr) {
    double nothing = 0;
    for (std::size_t i = 0; i < scene.seen().size(); ++i) nothing += scene.leave_out_cost(i);
    astray = std::exp((best.cost - nothing) / 2);
  }
  astray += odds_of_dispute(scene, list);
  const double all = 1 + others + astray;
  return {(others + astray) / all, astray / all};
}

/// What becomes of a sighting where no place of the camera is found.
SightingVerdict verdict_alone(const Scene& scene, std::size_t sighting) noexcept {
  const std::optional<std::size_t>& coded = scene.seen()[sighting].coded;
  SightingVerdict verdict{.use = SightingUse::kNotIdentified, .landmark = coded};
  if (coded && !scene.map()[*coded].has_place) verdict.use = SightingUse::kNoPlace;
  if (scene.is_known_moved(sighting)) verdict.use = SightingUse::kRejected;
  return verdict;
}

/// Seen where it hangs, but turned by eighths of its ring: small dots' colours were misread. A sheet whose colours are
/// beyond doubt was hung up so.
bool is_misread(const Scene& scene, std::size_t sighting, const WorldHypothesis& best) noexcept {
  if (!scene.is_known(sighting) || scene.seen()[sighting].others_odds < kBeyondDoubt) return false;
  Choice turned = coded_choice(scene, sighting);
  for (turned.turn = 1; turned.turn < kRingDotCount; ++turned.turn)
    if (disagreement_chi2(scene, sighting, turned, best) <= scene.options().max_disagreement_chi2) return true;
  return false;
}

SightingVerdict verdict_in(const Scene& scene, std::size_t sighting, const WorldHypothesis& best) noexcept {
  const Choice& choice = best.choices[sighting];
  if (choice.is_made()) return {SightingUse::kUsed, choice.landmark, choice.turn, best.against_rest_chi2[sighting]};
  Choice moved;
  if (scene.is_known(sighting) || scene.is_known_moved(sighting))
    moved = coded_choice(scene, sighting);
  else if (scene.is_anonymous(sighting) && scene.determines_pose(sighting))
    moved = nearest_unseen(scene, sighting, best);
  if (!moved.is_made() || !scene.determines_pose(sighting)) return verdict_alone(scene, sighting);
  if (is_misread(scene, sighting, best)) return {.use = SightingUse::kMisread, .landmark = moved.landmark};
  return {SightingUse::kRejected, moved.landmark, moved.turn, disagreement_chi2(scene, sighting, moved, best)};
}

WorldVerdict why_none(const Scene& scene) noexcept {
  const bool is_only_one_moved =
      scene.map().anonymous().size() == 1 && !scene.is_believed(scene.map().anonymous().front());
  bool has_place = false, is_moved = false, is_open = false;
  for (std::size_t i = 0; i < scene.seen().size(); ++i) {
    has_place |= scene.is_known(i) || scene.is_known_moved(i) || scene.is_anonymous(i);
    is_moved |= scene.is_known_moved(i) || (scene.is_anonymous(i) && is_only_one_moved);
    is_open |= scene.is_anonymous(i) && !is_only_one_moved;
  }
  if (is_open) return WorldVerdict::kAmbiguous;
  if (is_moved) return WorldVerdict::kOnlyMoved;
  return has_place ? WorldVerdict::kUndetermined : WorldVerdict::kNothingSeen;
}

}  // namespace

WorldSolver::WorldSolver(std::vector<PlacedLandmark> landmarks, const LandmarkGeometry& landmark,
                         const WorldOptions& options)
    : map_(std::move(landmarks)), landmark_(landmark), options_(options), moved_(map_.landmarks().size()) {}

WorldPose WorldSolver::solve(std::span<const SightedLandmark> seen, const WorldPrior* prior) noexcept {
  EXPECTS(seen.size() <= kMaxSightings);
  const Scene scene(seen, map_, moved_, landmark_, options_, prior);
  hypotheses_.clear();
  start_from_coded(scene);
  const bool is_complete = add_anonymous(scene);
  settle_all(scene, hypotheses_);
  if (is_track_contested(scene, hypotheses_)) weigh_without_track(scene, hypotheses_);
  return answer(scene, is_complete);
}

bool WorldSolver::add_anonymous(const Scene& scene) noexcept {
  const auto count = [&](auto is) { return static_cast<int>(std::ranges::count_if(scene.by_sureness(), is)); };
  const int sighted = count([&](std::size_t i) { return scene.is_anonymous(i); });
  if (sighted == 0) return true;
  bool is_complete = take_in_anonymous(scene, hypotheses_);
  const int known = count([&](std::size_t i) { return scene.is_known(i); });
  if (2 * most_used(hypotheses_) > known + sighted) return is_complete;
  // Colours say which sheet it is, and not that it hangs where it did.
  HypothesisList without_coded;
  is_complete &= start_without_coded(scene, sighted, without_coded);
  for (const WorldHypothesis& hypothesis : without_coded) {
    // Those that a coded one agrees with have come from that one.
    const bool is_there = known > 0 && std::ranges::any_of(hypotheses_, [&](const WorldHypothesis& other) {
                            return other.used >= hypothesis.used && is_same_place(other, hypothesis.T_world_camera);
                          });
    if (!is_there) is_complete &= hypotheses_.try_push_back(hypothesis);
  }
  // One that all others contradict may be the one that was moved: a black-and-white one alone has too many places to
  // try them all.
  return is_complete && (known == 0 || most_used(hypotheses_) > 1 || is_known_by_track(scene, hypotheses_));
}

bool WorldSolver::start_without_coded(const Scene& scene, int sighted, HypothesisList& list) noexcept {
  if (map_.anonymous().size() == 1) return start_with_the_only_one(scene, list);
  const bool is_near_complete = start_near_priors(scene, list);
  if (is_near_complete && 2 * most_used(list) > sighted) return true;
  // Without a track, or with one that does not explain what is seen: by the sheets' places among each other.
  pairs_.clear();
  const bool is_complete = start_with_pairs(scene, pairs_);
  // Where these say nothing, half of them may hang elsewhere, and the others be where the track expects them.
  if (pairs_.empty()) return is_complete && is_near_complete;
  list = pairs_;
  return is_complete;
}

void WorldSolver::start_from_coded(const Scene& scene) noexcept {
  InlineVector<std::size_t, kMaxSightings> known;
  for (const std::size_t i : scene.by_sureness())
    if (scene.is_known(i)) static_cast<void>(known.try_push_back(i));
  int pairs = 0;
  for (std::size_t b = 1; b < known.size(); ++b) {
    for (std::size_t a = 0; a < b && pairs < kMaxPairs; ++a) {
      // A majority that agrees can't be outvoted by what is left.
      if (2 * most_used(hypotheses_) > static_cast<int>(known.size())) continue;
      if (is_covered(hypotheses_, known[a], known[b])) continue;
      if (scene.seen()[known[a]].coded == scene.seen()[known[b]].coded) continue;  // a sheet and its reflection
      ++pairs;
      const std::size_t before = hypotheses_.size();
      start_with_pair(scene, known[a], coded_choice(scene, known[a]), known[b], coded_choice(scene, known[b]),
                      hypotheses_);
      for (std::size_t h = before; h < hypotheses_.size(); ++h)
        for (const std::size_t i : known)
          if (!uses(hypotheses_[h], *scene.seen()[i].coded)) try_add(scene, i, coded_choice(scene, i), hypotheses_[h]);
    }
  }
  for (const std::size_t i : known)
    if (!is_covered(hypotheses_, i, i)) start_alone(scene, i, coded_choice(scene, i), hypotheses_);
}

WorldPose WorldSolver::answer(const Scene& scene, bool is_complete) noexcept {
  WorldPose pose;
  for (std::size_t i = 0; i < scene.seen().size(); ++i)
    static_cast<void>(pose.sightings.try_push_back(verdict_alone(scene, i)));
  if (hypotheses_.empty()) {
    pose.verdict = why_none(scene);
    return pose;
  }
  const Odds odds = rank(scene, hypotheses_);
  pose.ambiguity = is_complete ? odds.others : 1;
  pose.astray = odds.astray;
  const WorldHypothesis& best = hypotheses_[0];
  pose.T_world_camera = best.T_world_camera;
  pose.covariance = best.normal.llt().solve(PoseInformation::Identity());
  pose.agrees_with_prior = best.agrees_with_prior;
  pose.is_contested = is_track_contested(scene, hypotheses_);
  pose.verdict = pose.ambiguity <= options_.max_ambiguity ? WorldVerdict::kValid : WorldVerdict::kAmbiguous;
  for (std::size_t i = 0; i < scene.seen().size(); ++i) pose.sightings[i] = verdict_in(scene, i, best);
  if (!pose.is_valid()) note_disputes(scene);
  if (pose.is_valid() && (!pose.is_contested || pose.ambiguity <= kSure * options_.max_ambiguity))
    remember(scene, pose);
  return pose;
}

/// Where those whose names are known contradict each other, each alone against each. One whose numbers were misread
/// contradicts nobody, and nobody it.
void WorldSolver::note_disputes(const Scene& scene) noexcept {
  if (most_used(hypotheses_) > 1) return;
  const auto is_misread_by = [&](std::size_t sighting, std::size_t other) {
    return std::ranges::any_of(hypotheses_, [&](const WorldHypothesis& hypothesis) {
      return hypothesis.choices[other].is_made() && is_misread(scene, sighting, hypothesis);
    });
  };
  for (const WorldHypothesis& hypothesis : hypotheses_) {
    const auto one = std::ranges::find_if(hypothesis.choices, &Choice::is_made);
    const auto sighting = static_cast<std::size_t>(one - hypothesis.choices.begin());
    if (!scene.is_known(sighting) || scene.seen()[sighting].is_smeared) continue;
    for (const std::size_t other : scene.by_sureness()) {
      if (!scene.is_known(other) || scene.seen()[other].coded == scene.seen()[sighting].coded) continue;
      if (scene.seen()[other].is_smeared) continue;
      const double beyond =
          disagreement_chi2(scene, other, coded_choice(scene, other), hypothesis) - options_.max_disagreement_chi2;
      if (!(beyond > 0)) continue;
      if (is_misread_by(other, sighting) || is_misread_by(sighting, other)) continue;
      moved_.dispute(one->landmark, beyond);
    }
  }
}

/// Of a picture that leaves no doubt: who is where the map says, and who is not.
void WorldSolver::remember(const Scene& scene, const WorldPose& pose) noexcept {
  // A track agrees that stands on others.
  const bool is_by_track = scene.prior() != nullptr && !pose.is_contested;
  for (std::size_t i = 0; i < scene.seen().size(); ++i) {
    const SightingVerdict& sighting = pose.sightings[i];
    if (sighting.use == SightingUse::kUsed && (hypotheses_[0].used > 1 || (is_by_track && pose.agrees_with_prior)))
      moved_.agrees(*sighting.landmark);
    if (sighting.use != SightingUse::kRejected || !sighting.landmark) continue;
    // Where it hangs it is seen as well: this is its reflection.
    if (uses(hypotheses_[0], *sighting.landmark)) continue;
    if (sighting.chi2_against_rest <= options_.max_disagreement_chi2)
      moved_.agrees(*sighting.landmark);
    else if (!scene.seen()[i].is_smeared)
      moved_.disagrees(*sighting.landmark, sighting.chi2_against_rest - options_.max_disagreement_chi2);
  }
}

}  // namespace ninedot
