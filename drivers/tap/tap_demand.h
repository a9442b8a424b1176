#pragma once
/// How much of the tap is wanted: by one reader, or by all of them together.
#include <cstdint>

namespace ninedot {

enum class TapDemand : std::uint8_t {
  kNothing,
  kSome,   ///< a frame every kTapSomePeriod_ns
  kEvery,  ///< all of them, for a recording
};

}  // namespace ninedot
