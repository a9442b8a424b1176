#include "world/contested_track.h"

#include <algorithm>
#include <limits>

namespace ninedot {
namespace {

bool stands_on_it(const Scene& scene, const WorldHypothesis& hypothesis) noexcept {
  return uses(hypothesis, *scene.prior()->stands_on);
}

/// What was known before against where the track has gone since: what the landmark that it stands on has to answer for.
double cost_of_track(const Scene& scene) noexcept {
  const WorldPrior& prior = *scene.prior();
  const PoseStep apart = step_between(prior.without->T_world_camera, prior.T_world_camera);
  const PoseCovariance covariance = prior.without->covariance + prior.covariance;
  return cost_by_prior(scene, *prior.without, apart.dot(covariance.llt().solve(apart)));
}

}  // namespace

bool is_track_contested(const Scene& scene, const HypothesisList& list) noexcept {
  return scene.prior() != nullptr && scene.prior()->stands_on &&
         std::ranges::any_of(list, [&](const WorldHypothesis& h) { return stands_on_it(scene, h); });
}

void weigh_without_track(const Scene& scene, HypothesisList& list) noexcept {
  // That the landmark is where its own track foretells it says nothing for its place in the map: what misses there
  // counts against all alike.
  double own_way = std::numeric_limits<double>::infinity();
  for (const WorldHypothesis& hypothesis : list)
    if (stands_on_it(scene, hypothesis)) own_way = std::min(own_way, hypothesis.prior_cost);
  const WorldPrior* without = scene.prior()->without;
  const double of_track = without != nullptr ? cost_of_track(scene) : 0;
  for (WorldHypothesis& hypothesis : list) {
    if (stands_on_it(scene, hypothesis)) continue;
    hypothesis.cost -= hypothesis.prior_cost;
    hypothesis.prior_cost = own_way;
    hypothesis.agrees_with_prior = true;
    if (without != nullptr) {
      const double chi2 = prior_chi2(*without, hypothesis);
      hypothesis.prior_cost += cost_by_prior(scene, *without, chi2) - of_track;
      hypothesis.agrees_with_prior = chi2 <= scene.options().max_disagreement_chi2;
    }
    hypothesis.cost += hypothesis.prior_cost;
  }
}

}  // namespace ninedot
