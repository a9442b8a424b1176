#pragma once
/// One account of a picture: which sighting is which landmark, and where the camera is then.
#include <array>

#include "base/inline_vector.h"
#include "world/scene.h"

namespace ninedot {

struct WorldHypothesis {
  WorldFromCamera T_world_camera;
  PoseInformation normal = PoseInformation::Zero();       ///< of all sightings used [1/m^2, 1/(m rad), 1/rad^2]
  std::array<Choice, kMaxSightings> choices;              ///< by sighting; not made: it is left out
  std::array<double, kMaxSightings> against_rest_chi2{};  ///< by sighting, of those used; of `settle` [1]
  int used = 0;                                           ///< sightings
  double crest_chi2 = 0;  ///< used == 1: what the picture says against this crest of its likelihood [1]
  double cost = 0;        ///< minus twice the logarithm of its likelihood; of `settle` [1]
  double prior_cost = 0;  ///< of `cost`, what the prior says against it; of `settle` [1]
  bool agrees_with_prior = true;
};

/// Whether one of its sightings is taken for this landmark. \param landmark  index [1]
bool uses(const WorldHypothesis& hypothesis, std::size_t landmark) noexcept;

/// Of one frame. What has no room is the least likely.
using HypothesisList = InlineVector<WorldHypothesis, 32>;

/// The hypotheses that one sighting alone allows, its two crests, are appended. \param sighting  index [1] \param
/// choice  made (contract) Memory: none. Threads: pure.
void start_alone(const Scene& scene, std::size_t sighting, const Choice& choice, HypothesisList& list) noexcept;

/// The same of two sightings that agree with each other; nothing is appended where they don't. Two at most.
/// \param first, second  indices of the sightings [1]
/// \return  whether they agree
bool start_with_pair(const Scene& scene, std::size_t first, const Choice& first_choice, std::size_t second,
                     const Choice& second_choice, HypothesisList& list) noexcept;

/// Takes a further sighting in if it agrees with those that are in. \param sighting  index [1] \pre used >= 1
/// (contract)
bool try_add(const Scene& scene, std::size_t sighting, const Choice& choice, WorldHypothesis& hypothesis) noexcept;

/// Chi^2 of six freedoms of a sighting that is not used against those that are [1]. \param sighting  index [1]
double disagreement_chi2(const Scene& scene, std::size_t sighting, const Choice& choice,
                         const WorldHypothesis& hypothesis) noexcept;

/// Fits all its sightings jointly, leaves out what disagrees after all, and works out what it costs.
/// \return  false: it is none; its sightings determine no pose
bool settle(const Scene& scene, WorldHypothesis& hypothesis) noexcept;

/// How far its place is from where a prior expects the camera: chi^2 of six freedoms [1].
double prior_chi2(const WorldPrior& prior, const WorldHypothesis& hypothesis) noexcept;
/// What that says against it: at most that the prior may itself be wrong. \param chi2  of six freedoms [1] \return  [1]
double cost_by_prior(const Scene& scene, const WorldPrior& prior, double chi2) noexcept;

/// Whether two places of the camera are one for the likelihood about `a`: within its covariance (95 %).
bool is_same_place(const WorldHypothesis& a, const WorldFromCamera& T_world_camera) noexcept;

}  // namespace ninedot
