#pragma once
/// The time from one row's exposure to the next one's of a camera whose shutter rolls.
#include <cstdint>

namespace ninedot {

enum class RowTimeSource : std::uint8_t {
  kTold,          ///< by the configuration, or by the frames themselves
  kOpen,          ///< nobody has told, and pictures have not shown yet
  kSeen,          ///< nobody has told, and pictures have shown it
  kContradicted,  ///< pictures have shown another one than was told
};

struct RowTime {
  double mean_s = 0;   ///< 0: all rows at once; below: the last row is read first
  double sigma_s = 0;  ///< 1-sigma; 0: as it was told, or nothing is known of it and it counts as known
  RowTimeSource source = RowTimeSource::kOpen;
};

}  // namespace ninedot
