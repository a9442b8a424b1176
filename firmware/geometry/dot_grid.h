#pragma once
/// A printed grid of dots for calibrations, three of them larger so that it can be told which dot is which.
///
/// The large ones stand around the middle: one, its right neighbour, and the one two below the first. No turn takes
/// these three to each other, so a part of the grid that shows them has one reading.
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <optional>
#include <string_view>
#include <vector>

#include "geometry/disc.h"

namespace ninedot {

struct DotGrid {
  int columns = 0, rows = 0;  ///< as the viewer sees it, kLeast..kMost each
  double pitch_m = 0;         ///< from dot to dot, both ways

  static constexpr int kLeast = 4, kMost = 40;  ///< number of dots each way [1]
  /// Of the pitch. White between two large dots is a quarter of it, which the outlines' pixels need.
  static constexpr double kDotShare = 0.5, kLargeDotShare = 0.75;

  bool operator==(const DotGrid&) const = default;

  std::size_t count() const noexcept { return static_cast<std::size_t>(columns) * static_cast<std::size_t>(rows); }
  std::size_t index(int column, int row) const noexcept {
    return static_cast<std::size_t>(row) * static_cast<std::size_t>(columns) + static_cast<std::size_t>(column);
  }
  /// Columns and rows of the three large dots, from the upper left as the viewer sees them.
  std::array<std::array<int, 2>, 3> large_dots() const noexcept {
    const int column = columns / 2 - 1, row = rows / 2 - 1;
    return {{{column, row}, {column + 1, row}, {column, row + 2}}};
  }
};

/// Row by row from the upper left, in the frame of a landmark's sheet: X0 to the viewer's left, Z0 up, the origin in
/// the middle.
std::vector<PlaneDisc> discs_of(const DotGrid& grid);

/// COLUMNSxROWS@PITCH, the pitch in mm: "9x7@25". \return  nothing: it is none, or out of range (pitch 1 to 1000 mm)
std::optional<DotGrid> parse_dot_grid(std::string_view text) noexcept;

}  // namespace ninedot
