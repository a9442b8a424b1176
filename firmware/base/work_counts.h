#pragma once
/// What the search for the landmark had to leave out, because a list of fixed capacity was full or the budget of a
/// picture used up.
#include <cstdint>

namespace ninedot {

/// Each but the last counts one thing left out, not one picture; since the start, all wrap at 2^32. All were 0 over the
/// recordings that show a landmark.
struct WorkCounts {
  std::uint32_t runs_cut = 0;        ///< dark stretches of a row (RegionFinder)
  std::uint32_t blobs_cut = 0;       ///< dark spots: more than kMaxBlobs, or than are measured (BlobFinder)
  std::uint32_t neighbours_cut = 0;  ///< spots around one that may be P9, or beside one on the ring (hypothesis.h)
  std::uint32_t hypotheses_cut = 0;  ///< spots that no guess began with, and guesses that the list had no room for
  std::uint32_t frames_cut = 0;      ///< frames that held more than their budget: the next one's search went on with it
};

}  // namespace ninedot
