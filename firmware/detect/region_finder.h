#pragma once
/// Connected regions of pixels darker than a threshold, with their moments.
#include <cstdint>
#include <span>
#include <vector>

#include "image/image_buffer.h"
#include "image/image_view.h"

namespace ninedot {

/// Pixels of one region, 8-neighbours joined. Sums are over its pixels' coordinates.
struct Region {
  std::int32_t area_px = 0;
  std::int32_t min_x = 0, end_x = 0;                ///< columns [min_x, end_x)
  std::int32_t min_y = 0, last_y = 0;               ///< rows min_y .. last_y
  std::int64_t sum_x = 0, sum_y = 0;                ///< [px]
  std::int64_t sum_xx = 0, sum_xy = 0, sum_yy = 0;  ///< of products [px^2]
};

/// Which regions are of interest. The moments of others are not worth their time.
struct RegionLimits {
  int min_area_px = 1;
  int max_side_px = 1 << 14;  ///< of the box around it
};

/// Rows become runs, runs that touch become regions (union-find; Rosenfeld & Pfaltz, "Sequential operations in digital
/// picture processing", J. ACM 13, 1966).
/// Memory: the constructor's. Threads: one caller.
class RegionFinder {
 public:
  RegionFinder(int max_width_px, int max_height_px);

  /// \param threshold  of half the picture's size: one value for 2 x 2 pixels; a pixel below it is dark
  /// \param first_row  those above it are passed over
  /// \return  regions within the limits that do not touch the picture's border, in the order of their first pixels,
  ///          valid until the next call. Texture with more runs than an eighth of the largest picture's pixels is cut
  ///          off at the bottom, and counted.
  std::span<const Region> find(const ImageView& picture, const ImageBuffer& threshold, const RegionLimits& limits,
                               int first_row = 0) noexcept;

  /// Runs that found no room, over all calls; wraps.
  std::uint32_t runs_cut() const noexcept { return runs_cut_; }

  /// The row from which on runs found no room in the last call; the picture's height where all had room.
  int cut_from_row() const noexcept { return cut_from_row_; }

 private:
  struct Run {
    std::int16_t begin, end;  // [begin, end) in its row
    std::int32_t parent;      // union-find: an earlier run of the same region, or itself
  };
  void find_runs(const ImageView& picture, const ImageBuffer& threshold, int first_row) noexcept;
  void join_runs(int rows) noexcept;
  void outline_regions(int rows) noexcept;
  void keep_regions(const ImageView& picture, const RegionLimits& limits) noexcept;
  void sum_moments(int rows) noexcept;
  std::int32_t root(std::int32_t i) noexcept;

  std::vector<Run> runs_;
  std::uint32_t runs_cut_ = 0;
  int cut_from_row_ = 0;
  std::vector<std::int32_t> region_of_run_;
  std::vector<std::int32_t> row_start_;  // first run of each row, and one past the last
  std::vector<Region> regions_;
  std::vector<std::int32_t> kept_;  // of each region: its index among those that are kept, or -1
  std::size_t region_count_ = 0;
};

}  // namespace ninedot
