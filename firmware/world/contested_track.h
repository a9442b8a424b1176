#pragma once
/// A track that has stood on one landmark alone of late (WorldPrior::stands_on) goes where that one takes it, and is no
/// witness for its place in the map. While that landmark is in view, those that contradict it are weighed by what was
/// known before.
#include "world/hypothesis.h"

namespace ninedot {

/// The landmark that the scene's prior stands on is in view: a hypothesis uses it.
/// Memory: none. Threads: pure; likewise below.
bool is_track_contested(const Scene& scene, const HypothesisList& list) noexcept;

/// Weighs settled hypotheses anew that do not use that landmark. \pre is_track_contested()
void weigh_without_track(const Scene& scene, HypothesisList& list) noexcept;

}  // namespace ninedot
