// Candidates are the votes themselves, those of the most certain pictures first. A candidate carries the uncertainty of
// its own picture, so that a poor one is no reason to reject a good one.
#include "mapping/place_vote.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <vector>

#include "base/contract.h"
#include "mapping/chi_square.h"

namespace ninedot {
namespace {

/// With so many pictures asked, and so many of them as candidates, 1000 landmarks take seconds; more pictures improve a
/// start value that the adjustment improves anyhow.
constexpr std::size_t kAskedPictures = 24, kCandidatePictures = 8;
/// Rotations count as much as they move something at this distance, for what "certain" means. [m]
constexpr double kArm_m = 1.0;
constexpr int kMeanSteps = 3;

double squared_distance(const PlaceVote& a, const WorldFromLandmark& place, const PlaceCovariance& covariance) {
  const PlaceStep step = step_between(place, a.place);
  return step.dot((a.covariance + covariance).ldlt().solve(step));
}

double variance_m2(const PlaceCovariance& covariance) {
  return covariance.topLeftCorner<3, 3>().trace() + kArm_m * kArm_m * covariance.bottomRightCorner<3, 3>().trace();
}

/// One picture's votes.
using Ballot = std::span<const PlaceVote>;

std::vector<Ballot> ballots_of(std::span<const PlaceVote> votes) {
  std::vector<Ballot> all;
  for (std::size_t begin = 0, end; begin < votes.size(); begin = end) {
    for (end = begin + 1; end < votes.size() && votes[end].picture == votes[begin].picture;) ++end;
    all.push_back(votes.subspan(begin, end - begin));
  }
  std::vector<Ballot> asked;
  for (std::size_t i = 0; i < std::min(all.size(), kAskedPictures); ++i)
    asked.push_back(all[i * all.size() / std::min(all.size(), kAskedPictures)]);
  std::ranges::stable_sort(asked, {}, [](const Ballot& ballot) { return variance_m2(ballot.front().covariance); });
  return asked;
}

struct Choice {
  const PlaceVote* vote;  ///< null: none of the picture's votes agrees
  double cost;
};

Choice choose(const Ballot& ballot, const WorldFromLandmark& place, const PlaceCovariance& covariance) {
  Choice best{nullptr, chi2_limit(6)};
  for (const PlaceVote& vote : ballot) {
    const double cost = vote.penalty_chi2 + squared_distance(vote, place, covariance);
    if (cost < best.cost) best = {&vote, cost};
  }
  return best;
}

double cost_of(const std::vector<Ballot>& ballots, const PlaceVote& candidate) {
  double sum = 0;
  for (const Ballot& ballot : ballots)
    sum += ballot.data() <= &candidate && &candidate < ballot.data() + ballot.size()
               ? candidate.penalty_chi2
               : choose(ballot, candidate.place, candidate.covariance).cost;
  return sum;
}

}  // namespace

WorldFromLandmark moved_by(const WorldFromLandmark& T_world_landmark, const PlaceStep& step) noexcept {
  return {exp_so3(step.tail<3>()) * T_world_landmark.rotation, T_world_landmark.translation_m + step.head<3>()};
}

PlaceStep step_between(const WorldFromLandmark& from, const WorldFromLandmark& to) noexcept {
  PlaceStep step;
  step << to.translation_m - from.translation_m, log_so3(to.rotation * from.rotation.transpose());
  return step;
}

PlaceConsensus find_consensus(std::span<const PlaceVote> votes) {
  EXPECTS(!votes.empty());
  const std::vector<Ballot> ballots = ballots_of(votes);
  struct Candidate {
    const PlaceVote* vote;
    double cost;
  };
  std::vector<Candidate> candidates;
  for (std::size_t i = 0; i < std::min(ballots.size(), kCandidatePictures); ++i)
    for (const PlaceVote& vote : ballots[i]) candidates.push_back({&vote, cost_of(ballots, vote)});
  const Candidate& best = *std::ranges::min_element(candidates, {}, &Candidate::cost);

  PlaceConsensus result{best.vote->place, best.vote->covariance, 0, ballots.size(),
                        std::numeric_limits<double>::infinity()};
  for (int round = 0; round < kMeanSteps; ++round) {
    PlaceCovariance information = PlaceCovariance::Zero();
    PlaceStep pull = PlaceStep::Zero();
    result.agreeing = 0;
    for (const Ballot& ballot : ballots) {
      const Choice choice = choose(ballot, result.place, result.covariance);
      if (choice.vote == nullptr) continue;
      const PlaceCovariance weight = choice.vote->covariance.inverse();
      information += weight;
      pull += weight * step_between(result.place, choice.vote->place);
      ++result.agreeing;
    }
    if (result.agreeing == 0) break;
    result.covariance = information.inverse();
    result.place = moved_by(result.place, result.covariance * pull);
  }
  for (const Candidate& other : candidates)
    if (squared_distance(*other.vote, result.place, result.covariance) > chi2_limit(6))
      result.lead_chi2 = std::min(result.lead_chi2, other.cost - best.cost);
  return result;
}

}  // namespace ninedot
