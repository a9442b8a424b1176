#pragma once
/// The states of the aiming, and what leads from one to another: one table, from which the code, the tests and the
/// table of docs/pan-tilt.md follow.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/aim_state.h"

namespace ninedot {

/// What may happen in a step. Of several at once the first in this order counts that leads anywhere from where it is.
enum class AimEvent : std::uint8_t { kHeld, kParked, kSeen, kCentred, kStrayed, kMissed, kSought, kGivenUp };
inline constexpr std::size_t kAimEventCount = 8;

struct AimEventWords {
  AimEvent event;
  std::string_view name;
  std::string_view meaning;
};

inline constexpr std::array<AimEventWords, kAimEventCount> kAimEvents{{
    {AimEvent::kHeld, "held", "the inhibit input is active, the head is not there, or the order is a set-point"},
    {AimEvent::kParked, "parked", "the order is to park, or nothing has been seen for `park_after_s`"},
    {AimEvent::kSeen, "seen", "a new frame shows the landmark that is to be followed"},
    {AimEvent::kCentred, "centred", "it is less than 3 deg from the middle of the picture"},
    {AimEvent::kStrayed, "strayed", "it is more than 6 deg from the middle of the picture"},
    {AimEvent::kMissed, "missed", "a new frame does not show it, or there has been no frame for 300 ms"},
    {AimEvent::kSought, "sought", "it has been out of sight for `coast_ms`, and the head may search"},
    {AimEvent::kGivenUp, "given up", "it has been out of sight for `coast_ms`, and the head may not search"},
}};

struct AimTransition {
  AimState from;
  AimEvent event;
  AimState to;
};

// clang-format off
inline constexpr auto kAimTransitions = [] {
  using enum AimState;
  using enum AimEvent;
  return std::to_array<AimTransition>({
    {kSearch,  kHeld, kHold}, {kSearch,  kParked, kPark}, {kSearch, kSeen, kAcquire},
    {kAcquire, kHeld, kHold}, {kAcquire, kParked, kPark}, {kAcquire, kCentred, kTrack},  {kAcquire, kMissed, kCoast},
    {kTrack,   kHeld, kHold}, {kTrack,   kParked, kPark}, {kTrack,   kStrayed, kAcquire}, {kTrack,  kMissed, kCoast},
    {kCoast,   kHeld, kHold}, {kCoast,   kParked, kPark}, {kCoast,  kSeen, kAcquire}, {kCoast, kSought, kSearch}, {kCoast, kGivenUp, kHold},
    {kHold,                              kParked, kPark}, {kHold,   kSeen, kAcquire}, {kHold,  kSought, kSearch},
    {kPark,    kHeld, kHold},                             {kPark,   kSeen, kAcquire}, {kPark,  kSought, kSearch}, {kPark,  kGivenUp, kHold},
  });
}();
// clang-format on

/// What happens in one step; bit i is the AimEvent of number i.
class AimEvents {
 public:
  constexpr void set(AimEvent event, bool happens) noexcept {
    if (happens) bits_ = static_cast<std::uint8_t>(bits_ | bit(event));
  }
  constexpr bool has(AimEvent event) const noexcept { return (bits_ & bit(event)) != 0; }

 private:
  static constexpr std::uint8_t bit(AimEvent event) noexcept {
    return static_cast<std::uint8_t>(1U << static_cast<unsigned>(event));
  }
  std::uint8_t bits_ = 0;
};

/// Where `event` leads from `from`; `from` itself where the table says nothing.
constexpr AimState next_aim_state(AimState from, AimEvent event) noexcept {
  for (const AimTransition& t : kAimTransitions)
    if (t.from == from && t.event == event) return t.to;
  return from;
}

/// The state after a step. kHeld and kParked stop the search for others: who is held or parked stays so.
constexpr AimState next_aim_state(AimState from, const AimEvents& events) noexcept {
  for (const AimEventWords& words : kAimEvents) {
    if (!events.has(words.event)) continue;
    const AimState to = next_aim_state(from, words.event);
    if (to != from || words.event == AimEvent::kHeld || words.event == AimEvent::kParked) return to;
  }
  return from;
}

/// The table for docs/pan-tilt.md: a row for each state, a column for each event, then what the events are. Markdown.
/// Memory: a string.
std::string aim_transitions_markdown();

}  // namespace ninedot
