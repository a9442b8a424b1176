#pragma once
/// Why what looked like a landmark is none: the codes, and the one place where they are put in words.
#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace ninedot {

/// The numbers stand in the tap (docs/tap.md): never renumber, only append.
enum class Refusal : std::uint8_t {
  kNone = 0,          ///< nothing speaks against it
  kFewOutlines = 1,   ///< too few dots are dark inside and bright outside all around
  kFaint = 2,         ///< ink and paper are closer to each other than the picture's noise lets believe
  kDarkBetween = 3,   ///< the paper between the dots is not blank
  kNoCentre = 4,      ///< blank paper, or another thing, is where P9 should be
  kOtherPattern = 5,  ///< blank paper is where dots should be, or other spots are between them
  kPoorFit = 6,       ///< its outlines are not those of a landmark in any pose
};

/// In the order of their numbers: what there is to say, for people.
inline constexpr auto kRefusalSentences = std::to_array<std::string_view>({
    "nothing speaks against it",
    "too few of its dots are there, dark within and bright around",
    "it is too faint for the picture's noise",
    "what lies between its dots is not blank paper",
    "it has no ninth dot in its middle",
    "blank paper is where dots should be, or other spots lie between them",
    "its outlines are not those of a landmark",
});
static_assert(kRefusalSentences.size() == static_cast<std::size_t>(Refusal::kPoorFit) + 1);

/// \param code  a Refusal, or a number from another machine
constexpr std::string_view refusal_sentence(std::uint32_t code) noexcept {
  return code < kRefusalSentences.size() ? kRefusalSentences[code] : "unknown (a newer service?)";
}
constexpr std::string_view refusal_sentence(Refusal refusal) noexcept {
  return refusal_sentence(static_cast<std::uint32_t>(refusal));
}

}  // namespace ninedot
