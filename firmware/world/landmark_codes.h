#pragma once
/// Colour codes of landmarks: the letters of P1..P8, each K (black), R, G or B. No letters are black and white, as is
/// K alone. Memory: none, in all of this file. Threads: pure.
#include <optional>
#include <string_view>

namespace ninedot {

/// Eight letters, all of K R G B.
bool is_landmark_code(std::string_view code) noexcept;

/// No letters, or K alone.
bool is_black_and_white(std::string_view code) noexcept;

/// How near two codes come when one of the sheets is turned in its plane.
struct CodeDistance {
  int places = 0;  ///< 0..8, of P1..P8: in how many the colours differ
  int turn = 0;    ///< by how many dots (45 degrees each), clockwise as the viewer of the sheet sees it; the least
};

/// The nearest that the sheet of `b`, turned by 0..7 dots, comes to the upright one of `a`. The order of the two
/// changes the turn alone. \param a, b  is_landmark_code, or empty (contract)
CodeDistance code_distance(std::string_view a, std::string_view b) noexcept;

/// The nearest that a sheet, turned by 1..7 dots, comes to itself: 0 places, and nobody can tell which way is up, or 2
/// and more. Of black and white always 0: there P1 is found by which way is down. \param code  as above
CodeDistance own_distance(std::string_view code) noexcept;

/// Landmarks that come nearer to each other, or to their own turns, do not belong into one map: from 2 places on no
/// single misread dot makes one code another.
inline constexpr int kLeastCodeDistance = 2;

/// The dictionary that `ninedot pattern --id` prints, ids 1 to kKnownCodes. Whatever the turn, a code differs from
/// every other one, from its own turns and from black and white in 3 places at least, which tells whose code it is
/// where one dot was misread; the first kFarCodes in 4 among themselves, which also tells that two were. Found by
/// tests/bench/codes.
inline constexpr int kFarCodes = 27, kKnownCodes = 160;

/// Code of a landmark of the dictionary; empty for 0, which is black and white. Nothing for other numbers.
std::optional<std::string_view> known_code(int landmark_id) noexcept;

/// Number of the landmark with this code: 0 for black and white, 1..kKnownCodes, or nothing. Turns of a code are not
/// looked for.
std::optional<int> known_id(std::string_view code) noexcept;

}  // namespace ninedot
