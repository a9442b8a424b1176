#pragma once
/// What the pan/tilt head is doing: the states, and the one place where they are named and put in words.
/// Who goes from which to which: aim/aim_transitions.h.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace ninedot {

/// The numbers are register values: never renumber, only append.
enum class AimState : std::uint16_t {
  kNone = 0,
  kSearch = 1,
  kAcquire = 2,
  kTrack = 3,
  kCoast = 4,
  kHold = 5,
  kPark = 6,
};
inline constexpr std::size_t kAimStateCount = 7;

/// It looks for the landmark, or goes by it: nobody has sent it elsewhere.
constexpr bool follows(AimState state) noexcept {
  switch (state) {
    case AimState::kSearch:
    case AimState::kAcquire:
    case AimState::kTrack:
    case AimState::kCoast:
      return true;
    case AimState::kNone:
    case AimState::kHold:
    case AimState::kPark:
      break;
  }
  return false;
}

struct AimStateWords {
  AimState state;
  std::string_view name;      ///< upper case
  std::string_view sentence;  ///< for tables and documents
};

/// In the order of their numbers.
inline constexpr std::array<AimStateWords, kAimStateCount> kAimStates{{
    {AimState::kNone, "NONE", "there is no head"},
    {AimState::kSearch, "SEARCH", "it sweeps what it can see, for the landmark"},
    {AimState::kAcquire, "ACQUIRE", "it turns to the landmark, which is in sight"},
    {AimState::kTrack, "TRACK", "it keeps the landmark near the middle of the picture"},
    {AimState::kCoast, "COAST", "the landmark is hidden: it follows where that should be by now"},
    {AimState::kHold, "HOLD", "it stays: at a set-point, inhibited, or with nothing to follow"},
    {AimState::kPark, "PARK", "it goes to its parking place and stays there"},
}};

constexpr std::string_view name_of(AimState state) noexcept {
  for (const AimStateWords& words : kAimStates)
    if (words.state == state) return words.name;
  return "";
}

}  // namespace ninedot
