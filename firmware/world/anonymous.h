#pragma once
/// Which of the map's black-and-white landmarks the black-and-white sightings are: by where they are, never by guess.
///
/// One of them looks like the other, and each in eight numberings. What tells them apart is where they hang: from each
/// other (pairs of sightings against pairs of the map), from coded ones, or from where a track expects the camera.
/// Everything here makes hypotheses; which is right is decided by their likelihoods, and where two that differ in the
/// camera's place come out alike, neither is.
///
/// Work is bounded whatever the map: kMaxPairsTested pairs of the map are looked at by their distances and angles, and
/// kMaxPairsFitted fitted; where there are more the answer is ambiguous.
#include "world/hypothesis.h"

namespace ninedot {

inline constexpr int kMaxPairsTested = 20000, kMaxPairsFitted = 96;

/// Takes the black-and-white sightings into the hypotheses that there are, each where its landmark hangs. Where several
/// landmarks do, each makes a hypothesis.
/// \return  false: there were more than the list has room for; the list is not complete
/// Memory: none. Threads: pure; likewise all below.
bool take_in_anonymous(const Scene& scene, HypothesisList& list) noexcept;

/// The hypotheses that a prior allows are appended: the landmarks near where a sighting's is expected.
/// \param prior  the scene's, or its `without`
bool start_near_prior(const Scene& scene, const WorldPrior& prior, HypothesisList& list) noexcept;

/// The same for a map with one black-and-white landmark: it is that one, in one of eight numberings.
bool start_with_the_only_one(const Scene& scene, HypothesisList& list) noexcept;

/// The same for two or more sightings, without anything else: pairs of them that look like pairs of the map.
bool start_with_pairs(const Scene& scene, HypothesisList& list) noexcept;

/// The black-and-white landmark that hangs where a sighting that nothing explains is, to half a metre: it was moved.
/// None: nothing hangs there that is not seen elsewhere. \param sighting  index [1]
Choice nearest_unseen(const Scene& scene, std::size_t sighting, const WorldHypothesis& hypothesis) noexcept;

}  // namespace ninedot
