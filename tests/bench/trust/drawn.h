#pragma once
/// The jobs of everything that is drawn: near misses, views, camera effects.
#include <functional>
#include <vector>

#include "tests/bench/trust/strip.h"

namespace ninedot::bench {

struct DrawnJobs {
  std::vector<Kind> kinds;  ///< in the order of the page
  std::vector<Job> jobs;
};

/// \param frames  pictures of each kind; views and effects come twice, alone and as tracks of ten frames
/// \param seed  another one, other pictures; what a kind draws does not depend on which others are wanted
DrawnJobs drawn_jobs(const std::function<bool(const Kind&)>& is_wanted, int frames, std::uint64_t seed);

}  // namespace ninedot::bench
