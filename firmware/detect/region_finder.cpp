#include "detect/region_finder.h"

#include <algorithm>
#include <bit>
#include <opencv2/core/hal/intrin.hpp>

#include "base/contract.h"
#include "image/vector_operators.h"

namespace ninedot {
namespace {

/// Bit i: pixel i of 32 is below its threshold, which two pixels share.
std::uint32_t dark_bits(const std::uint8_t* pixels, const std::uint8_t* limits) noexcept {
  const cv::v_uint8x16 limit = cv::v_load(limits);
  cv::v_uint8x16 low, high;
  cv::v_zip(limit, limit, low, high);
  const auto below = [](const std::uint8_t* at, const cv::v_uint8x16& than) {
    return static_cast<std::uint32_t>(cv::v_signmask(less(cv::v_load(at), than))) & 0xFFFFU;
  };
  return below(pixels, low) | below(pixels + 16, high) << 16;
}

/// The same of the last columns of a row, fewer than 32.
/// \param width  of the row, even
std::uint32_t last_dark_bits(const std::uint8_t* pixels, const std::uint8_t* limits, int width, int count) noexcept {
  if (width >= 32) return dark_bits(pixels + width - 32, limits + (width - 32) / 2) >> (31 - count) >> 1;
  std::uint32_t bits = 0;
  for (int x = width - count; x < width; ++x)
    bits |= static_cast<std::uint32_t>(pixels[x] < limits[x / 2]) << (x - width + count);
  return bits;
}

}  // namespace

RegionFinder::RegionFinder(int max_width_px, int max_height_px)
    // Worst texture: a run for every second pixel. Kept to a quarter of that; noise beyond is cut, not followed.
    : runs_(static_cast<std::size_t>(max_width_px) * static_cast<std::size_t>(max_height_px) / 8 + 64),
      region_of_run_(runs_.size()),
      row_start_(static_cast<std::size_t>(max_height_px) + 1),
      regions_(runs_.size()),
      kept_(runs_.size()) {
  EXPECTS(max_width_px < 32768 && max_height_px < 32768);
}

std::span<const Region> RegionFinder::find(const ImageView& picture, const ImageBuffer& threshold,
                                           const RegionLimits& limits, int first_row) noexcept {
  EXPECTS(static_cast<std::size_t>(picture.height_px) < row_start_.size());
  find_runs(picture, threshold, first_row);
  join_runs(picture.height_px);
  outline_regions(picture.height_px);
  keep_regions(picture, limits);
  sum_moments(picture.height_px);
  return std::span(regions_).first(region_count_);
}

void RegionFinder::find_runs(const ImageView& picture, const ImageBuffer& threshold, int first_row) noexcept {
  cut_from_row_ = picture.height_px;
  Run* const runs = runs_.data();
  const auto room = static_cast<std::int32_t>(runs_.size());
  std::int32_t count = 0;
  const int width = 2 * (picture.width_px / 2);  // an odd last column has no threshold
  for (int y = 0; y < picture.height_px; ++y) {
    row_start_[static_cast<std::size_t>(y)] = count;
    if (y < first_row) continue;
    const std::uint8_t* pixels = picture.row(y);
    const std::uint8_t* limits = threshold.row(std::min(y / 2, threshold.height_px() - 1));
    const auto end_run = [&](int begin, int end) {
      if (count == room) {
        ++runs_cut_;
        cut_from_row_ = std::min(cut_from_row_, y);
        return;
      }
      runs[count] = {static_cast<std::int16_t>(begin), static_cast<std::int16_t>(end), count};
      ++count;
    };
    std::uint32_t inside = 0;  // 1 while the pixel before was dark
    int begin = 0;
    for (int x = 0; x <= width; x += 32) {
      const int left = width - x;
      const std::uint32_t bits =
          left >= 32 ? dark_bits(pixels + x, limits + x / 2) : last_dark_bits(pixels, limits, width, left);
      std::uint32_t edges = bits ^ ((bits << 1) | inside);  // set where it changes
      const auto next_edge = [&] {
        const int at = x + std::countr_zero(edges);
        edges &= edges - 1;
        return at;
      };
      if (edges != 0 && inside != 0) end_run(begin, next_edge());
      while (edges != 0) {
        begin = next_edge();
        if (edges == 0) break;
        end_run(begin, next_edge());
      }
      inside = bits >> 31;
    }
  }
  row_start_[static_cast<std::size_t>(picture.height_px)] = count;
}

std::int32_t RegionFinder::root(std::int32_t i) noexcept {
  Run* runs = runs_.data();
  std::int32_t parent = runs[i].parent;
  while (parent != i) {
    const std::int32_t grandparent = runs[parent].parent;
    if (grandparent == parent) break;
    runs[i].parent = grandparent;
    i = grandparent;
    parent = runs[i].parent;
  }
  return parent;
}

void RegionFinder::join_runs(int rows) noexcept {
  Run* runs = runs_.data();
  for (int y = 1; y < rows; ++y) {
    std::int32_t above = row_start_[static_cast<std::size_t>(y) - 1];
    const std::int32_t first = row_start_[static_cast<std::size_t>(y)];
    const std::int32_t last = row_start_[static_cast<std::size_t>(y) + 1];
    for (std::int32_t here = first; here < last; ++here) {
      const Run run = runs[here];
      while (above < first && runs[above].end < run.begin) ++above;
      std::int32_t mine = here;  // its root
      for (std::int32_t other = above; other < first && runs[other].begin <= run.end; ++other) {
        // The smaller index is the root, so that it comes first in every later pass.
        const std::int32_t theirs = root(other);
        if (theirs < mine) {
          runs[mine].parent = theirs;
          mine = theirs;
        } else {
          runs[theirs].parent = mine;
        }
      }
    }
  }
}

/// Which region each run belongs to, and the areas and boxes of all regions.
void RegionFinder::outline_regions(int rows) noexcept {
  region_count_ = 0;
  const Run* runs = runs_.data();
  std::int32_t* region_of = region_of_run_.data();
  for (int y = 0; y < rows; ++y) {
    const std::int32_t last = row_start_[static_cast<std::size_t>(y) + 1];
    for (std::int32_t i = row_start_[static_cast<std::size_t>(y)]; i < last; ++i) {
      const Run run = runs[i];
      if (run.parent == i) {
        region_of[i] = static_cast<std::int32_t>(region_count_);
        Region& region = regions_[region_count_++];
        region.area_px = run.end - run.begin;
        region.min_x = run.begin, region.end_x = run.end;
        region.min_y = region.last_y = y;
        continue;
      }
      region_of[i] = region_of[run.parent];  // parents come earlier
      Region& region = regions_[static_cast<std::size_t>(region_of[i])];
      region.area_px += run.end - run.begin;
      region.min_x = std::min<std::int32_t>(region.min_x, run.begin);
      region.end_x = std::max<std::int32_t>(region.end_x, run.end);
      region.last_y = y;
    }
  }
}

void RegionFinder::keep_regions(const ImageView& picture, const RegionLimits& limits) noexcept {
  std::size_t kept = 0;
  for (std::size_t i = 0; i < region_count_; ++i) {
    const Region& r = regions_[i];
    const bool wanted = r.area_px >= limits.min_area_px && r.end_x - r.min_x <= limits.max_side_px &&
                        r.last_y - r.min_y < limits.max_side_px && r.min_x > 0 && r.min_y > 0 &&
                        r.end_x < picture.width_px && r.last_y < picture.height_px - 1;
    kept_[i] = wanted ? static_cast<std::int32_t>(kept) : -1;
    if (!wanted) continue;
    regions_[kept] = r;
    Region& to = regions_[kept++];
    to.sum_x = to.sum_y = to.sum_xx = to.sum_xy = to.sum_yy = 0;
  }
  region_count_ = kept;
}

void RegionFinder::sum_moments(int rows) noexcept {
  const auto squares_below = [](std::int64_t n) { return (n - 1) * n * (2 * n - 1) / 6; };  // 0^2 + .. + (n - 1)^2
  for (int y = 0; y < rows; ++y) {
    const std::int32_t last = row_start_[static_cast<std::size_t>(y) + 1];
    for (std::int32_t i = row_start_[static_cast<std::size_t>(y)]; i < last; ++i) {
      const Run& run = runs_[static_cast<std::size_t>(i)];
      const std::int32_t kept = kept_[static_cast<std::size_t>(region_of_run_[static_cast<std::size_t>(i)])];
      if (kept < 0) continue;
      Region& r = regions_[static_cast<std::size_t>(kept)];
      const std::int64_t n = run.end - run.begin;
      const std::int64_t sum_x = n * (run.begin + run.end - 1) / 2;
      r.sum_x += sum_x;
      r.sum_y += n * y;
      r.sum_xx += squares_below(run.end) - squares_below(run.begin);
      r.sum_xy += sum_x * y;
      r.sum_yy += n * y * y;
    }
  }
}

}  // namespace ninedot
