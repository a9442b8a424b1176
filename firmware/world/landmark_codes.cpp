// Two bits a letter, P1 lowest: a turn of the sheet is a rotation of 16 bits, and letters are compared all at once.
#include "world/landmark_codes.h"

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "base/contract.h"
#include "geometry/landmark.h"

namespace ninedot {
namespace {

constexpr std::string_view kLetters = "KRGB";
constexpr int kTurns = static_cast<int>(kRingDotCount);

// clang-format off
/// In the order of their ids. 1 to 16 are those of sheets and recordings that there were before; the rest is what
/// `codes` prints.
constexpr std::array<std::string_view, kKnownCodes> kDictionary{
    "KRGBKKRB", "RRGKBGKB", "KKGRRBGB", "RKBGGKRB", "BKKRGRGB", "BKGKGKGR", "BGRBKKBK", "BGGGKRGG", "BBGRBRBK",
    "BBBRKKKG", "BKRRGGRK", "BRGRRGGK", "BBKGBRGR", "BBRBBRKG", "BGRRRKGG", "BGKKGRKG", "KKKBRRKR", "KKBKGBKR",
    "KKBGKRKG", "KKBBBKGG", "KRKRRRRB", "KRGBRRBG", "KRBGBRRR", "KBRGGGRR", "KBRBBBGR", "RRGRGRGG", "RBGGBBGB",
    "KKKKRGGB", "KKKKGGRR", "KKKKBGBG", "KKKRRKBR", "KKKRGBKG", "KKKRBGKB", "KKKGKKRR", "KKKGRGRG", "KKKGGKGG",
    "KKKGBRGB", "KKKBKGGG", "KKKBRBBG", "KKKBBKRB", "KKRKKGKB", "KKRKRKGR", "KKRKGKRG", "KKRKBBBB", "KKRRRRKB",
    "KKRRGGGG", "KKRRGBBR", "KKRGRBRR", "KKRGGRGR", "KKRBKBKR", "KKRBRRRG", "KKRBGGRB", "KKRBBRBR", "KKGKRBBR",
    "KKGKGRKB", "KKGKGBGG", "KKGRRRRR", "KKGRBRKG", "KKGGKBRB", "KKGGGRBG", "KKGGGGKR", "KKGGBKRG", "KKGBKGRR",
    "KKGBGBBB", "KKGBBGGB", "KKBKKBRG", "KKBKRKBG", "KKBKBRGR", "KKBRKGGB", "KKBGKGBR", "KKBGRBGG", "KKBGBKBB",
    "KKBBRGGR", "KKBBGKRR", "KKBBGGKG", "KRKRRGBG", "KRKRGBGB", "KRKGGGBR", "KRKGGBRG", "KRKBRBGR", "KRKBBRKG",
    "KRKBBGRR", "KRRKRRBR", "KRRKBGRG", "KRRRKGBR", "KRRRGKRB", "KRRRBRGR", "KRRGBRBG", "KRRBRGGB", "KRGKGRGR",
    "KRGKBGBR", "KRGRKRBB", "KRGRRKGR", "KRGRRGKB", "KRGRRBRG", "KRGRBKBG", "KRGGKBGR", "KRGGGKBB", "KRGBGKGG",
    "KRBKGGKB", "KRBKBBKG", "KRBRRGRR", "KRBRRBBB", "KRBRGKBR", "KRBRBRKB", "KRBGBBGB", "KRBBGRRB", "KRBBBGBB",
    "KGKGRRGR", "KGKGGBBB", "KGKGBRRG", "KGKBRGBB", "KGKBGRGG", "KGKBBKGR", "KGRKBGGB", "KGRRRBBG", "KGRRBBKB",
    "KGRGKBGG", "KGRGGGBG", "KGRGBKBR", "KGRBGGGR", "KGRBGBRG", "KGRBBRRB", "KGGRGBGR", "KGGRBGRR", "KGGGGRGB",
    "KGGBRBRB", "KGBKGBBG", "KGBKBBRR", "KGBRBRGG", "KGBGRRBG", "KGBGRGGB", "KGBBBGRG", "KBKBGGGB", "KBKBBBRG",
    "KBRRKBBB", "KBRRBGRB", "KBRBRGBG", "KBRBBKBB", "KBGGRBBG", "KBGGBGBB", "KBGBRRGR", "KBGBGGBR", "KBBRGRGR",
    "KBBRBGBG", "KBBGGBBR", "KBBBGBGG", "RRRRBRBB", "RRRGGBBB", "RRRGBBGG", "RRGGBRRB", "RRGBRGBB", "RRGBGBBG",
    "RRBBBRBG", "RGRBGRBB", "RGGRBRBG", "RGGGGGBB", "RGGGGBGG", "RGBGBRBB", "RBBBBGGG"};
// clang-format on

std::uint16_t packed(std::string_view code) noexcept {
  EXPECTS(code.empty() || is_landmark_code(code));
  unsigned bits = 0;
  for (std::size_t dot = 0; dot < code.size(); ++dot)
    bits |= static_cast<unsigned>(kLetters.find(code[dot])) << 2 * dot;
  return static_cast<std::uint16_t>(bits);
}

int places_between(std::uint16_t a, std::uint16_t b) noexcept {
  const unsigned differing = a ^ b;
  return std::popcount((differing | differing >> 1) & 0x5555U);
}

CodeDistance least_distance(std::uint16_t a, std::uint16_t b, int first_turn) noexcept {
  CodeDistance least{kTurns + 1, 0};
  for (int turn = first_turn; turn < kTurns; ++turn)
    // P1..P8 run clockwise: after a turn by one dot P1 is where P2 was.
    if (const int places = places_between(a, std::rotl(b, 2 * turn)); places < least.places) least = {places, turn};
  return least;
}

}  // namespace

bool is_landmark_code(std::string_view code) noexcept {
  return code.size() == kRingDotCount && code.find_first_not_of(kLetters) == std::string_view::npos;
}

bool is_black_and_white(std::string_view code) noexcept {
  return code.find_first_not_of('K') == std::string_view::npos;
}

CodeDistance code_distance(std::string_view a, std::string_view b) noexcept {
  return least_distance(packed(a), packed(b), 0);
}

CodeDistance own_distance(std::string_view code) noexcept {
  const std::uint16_t bits = packed(code);
  return least_distance(bits, bits, 1);
}

std::optional<std::string_view> known_code(int landmark_id) noexcept {
  if (landmark_id < 0 || landmark_id > kKnownCodes) return std::nullopt;
  return landmark_id == 0 ? std::string_view() : kDictionary[static_cast<std::size_t>(landmark_id - 1)];
}

std::optional<int> known_id(std::string_view code) noexcept {
  if (is_black_and_white(code)) return 0;
  for (int id = 1; id <= kKnownCodes; ++id)
    if (*known_code(id) == code) return id;
  return std::nullopt;
}

}  // namespace ninedot
