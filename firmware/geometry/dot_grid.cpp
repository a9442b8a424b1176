#include "geometry/dot_grid.h"

#include <algorithm>
#include <charconv>

namespace ninedot {
namespace {

constexpr double kLeastPitch_mm = 1, kMostPitch_mm = 1000;

/// Takes a number and the letter behind it off the text. \param after  0: the text's end
template <typename Number>
bool take(std::string_view& text, char after, Number& number) noexcept {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{}) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  if (after == 0) return text.empty();
  if (!text.starts_with(after)) return false;
  text.remove_prefix(1);
  return true;
}

}  // namespace

std::vector<PlaneDisc> discs_of(const DotGrid& grid) {
  std::vector<PlaneDisc> discs;
  const auto large = grid.large_dots();
  for (int row = 0; row < grid.rows; ++row)
    for (int column = 0; column < grid.columns; ++column) {
      const bool is_large = std::ranges::find(large, std::array<int, 2>{column, row}) != large.end();
      const double x = 0.5 * (grid.columns - 1) - column, z = 0.5 * (grid.rows - 1) - row;
      discs.push_back({grid.pitch_m * Eigen::Vector2d(x, z),
                       grid.pitch_m * (is_large ? DotGrid::kLargeDotShare : DotGrid::kDotShare) / 2});
    }
  return discs;
}

std::optional<DotGrid> parse_dot_grid(std::string_view text) noexcept {
  DotGrid grid;
  double pitch_mm = 0;
  if (!take(text, 'x', grid.columns) || !take(text, '@', grid.rows) || !take(text, 0, pitch_mm)) return std::nullopt;
  const auto fits = [](int dots) { return dots >= DotGrid::kLeast && dots <= DotGrid::kMost; };
  if (!fits(grid.columns) || !fits(grid.rows) || !(pitch_mm >= kLeastPitch_mm && pitch_mm <= kMostPitch_mm))
    return std::nullopt;
  grid.pitch_m = pitch_mm / 1000;
  return grid;
}

}  // namespace ninedot
