#include "programs/service/status_led.h"

#include <array>
#include <chrono>
#include <cstddef>
#include <string_view>

namespace ninedot {
namespace {

/// One letter for 100 ms, # = lit; in the order of LedPattern.
constexpr std::array<std::string_view, 4> kPictures{
    "####################",
    "#####.....#####.....",
    "#.#.................",
    "#.#.#.#.#.#.#.#.#.#.",
};

}  // namespace

LedPattern led_pattern_of(const Report& report) noexcept {
  if (report.head.failed) return LedPattern::kFault;
  switch (report.reason) {
    case Reason::kNone:
      return LedPattern::kTracking;
    case Reason::kStarting:
    case Reason::kCameraLost:
      return LedPattern::kNoCamera;
    case Reason::kNoLandmark:
    case Reason::kPoseDegenerate:
    case Reason::kAmbiguous:
    case Reason::kUncertain:
    case Reason::kPoorFit:
    case Reason::kCrowded:
    case Reason::kNotIdentified:
    case Reason::kMoved:
    case Reason::kZoom:
    case Reason::kStale:
    case Reason::kHeld:
      return LedPattern::kNoLandmark;
    case Reason::kFrameSize:
    case Reason::kFrameUnreadable:
    case Reason::kStopped:
      break;
  }
  return LedPattern::kFault;
}

bool is_led_lit(LedPattern pattern, MonoTime now) noexcept {
  const std::string_view picture = kPictures[static_cast<std::size_t>(pattern)];
  const auto letter = static_cast<std::size_t>(to_ns(now) / 100'000'000) % picture.size();
  return picture[letter] == '#';
}

}  // namespace ninedot
