#include "world/landmark_codes.h"

#include <array>

#include "geometry/landmark.h"

namespace ninedot {
namespace {

/// The dictionary that `ninedot pattern --id` prints; the test of this file holds it to what the header promises.
constexpr std::array<std::string_view, 6> kKnownCodes{"", "KRGBKKRB", "RRGKBGKB", "KKGRRBGB", "RKBGGKRB", "BKKRGRGB"};

bool is_turned_by(std::string_view a, std::string_view b, std::size_t turn) noexcept {
  return a.substr(turn) == b.substr(0, a.size() - turn) && a.substr(0, turn) == b.substr(a.size() - turn);
}

}  // namespace

bool is_landmark_code(std::string_view code) noexcept {
  return code.size() == kRingDotCount && code.find_first_not_of("KRGB") == std::string_view::npos;
}

bool is_black_and_white(std::string_view code) noexcept {
  return code.find_first_not_of('K') == std::string_view::npos;
}

std::optional<std::size_t> find_own_turn(std::string_view code) noexcept {
  if (is_black_and_white(code)) return std::nullopt;
  for (std::size_t turn = 1; turn < code.size(); ++turn)
    if (is_turned_by(code, code, turn)) return turn;
  return std::nullopt;
}

bool is_turn_of(std::string_view a, std::string_view b) noexcept {
  if (a.size() != b.size()) return false;
  if (a == b) return true;
  for (std::size_t turn = 1; turn < a.size(); ++turn)
    if (is_turned_by(a, b, turn)) return true;
  return false;
}

std::optional<std::string> known_code(int landmark_id) {
  if (landmark_id < 0 || static_cast<std::size_t>(landmark_id) >= kKnownCodes.size()) return std::nullopt;
  return std::string(kKnownCodes[static_cast<std::size_t>(landmark_id)]);
}

std::optional<int> known_id(std::string_view code) noexcept {
  if (is_black_and_white(code)) return 0;
  for (std::size_t id = 1; id < kKnownCodes.size(); ++id)
    if (kKnownCodes[id] == code) return static_cast<int>(id);
  return std::nullopt;
}

}  // namespace ninedot
