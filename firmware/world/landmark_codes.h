#pragma once
/// Colour codes of landmarks: the letters of P1..P8, each K (black), R, G or B.
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

namespace ninedot {

/// Eight letters, all of K R G B.
bool is_landmark_code(std::string_view code) noexcept;

/// No letters, or K alone.
bool is_black_and_white(std::string_view code) noexcept;

/// By how many dots (1..7) a sheet must be turned to look the same: then nobody can tell which way is up. The least;
/// nothing where it never does, and for black and white, where P1 is found by which way is down.
std::optional<std::size_t> find_own_turn(std::string_view code) noexcept;

/// Whether a turned sheet with code `a` looks like one with code `b`; also where they are the same.
bool is_turn_of(std::string_view a, std::string_view b) noexcept;

/// Code of the landmarks 1..5, which differ from every turn of themselves and of each other; empty for 0, which is
/// black and white. Nothing for other numbers.
std::optional<std::string> known_code(int landmark_id);

/// Number of the landmark with this code: 0 for black and white, 1..5, or nothing.
std::optional<int> known_id(std::string_view code) noexcept;

}  // namespace ninedot
