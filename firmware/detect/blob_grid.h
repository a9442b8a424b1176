#pragma once
/// Which blobs are near a place, without looking at all of them.
#include <algorithm>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "detect/blob.h"

namespace ninedot {

/// Blobs by square cells of the picture. Memory: the constructor's. Threads: one caller builds; const is safe.
class BlobGrid {
 public:
  static constexpr int kCell_px = 32;

  BlobGrid(int width_px, int height_px)
      : columns_(width_px / kCell_px + 1),
        rows_(height_px / kCell_px + 1),
        first_(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_)) {}

  /// Forgets what was there. Indices are those in `blobs`; places outside of the picture count as its border,
  /// what is not a number as its left or upper one.
  void build(std::span<const Blob> blobs) noexcept {
    std::fill(first_.begin(), first_.end(), std::int16_t{-1});
    // Backwards, so that the first of a cell comes first.
    for (std::size_t i = blobs.size(); i-- > 0;) {
      std::int16_t& head = first_[cell(column(blobs[i].x_px), row(blobs[i].y_px))];
      next_[i] = head;
      head = static_cast<std::int16_t>(i);
    }
  }

  /// Calls use(index) for every blob of the cells that the square of half the side `reach_px` around a place touches.
  template <typename Use>
  void for_each_near(float x_px, float y_px, float reach_px, Use&& use) const noexcept {
    const int x0 = column(x_px - reach_px), x1 = column(x_px + reach_px);
    const int y0 = row(y_px - reach_px), y1 = row(y_px + reach_px);
    for (int y = y0; y <= y1; ++y)
      for (int x = x0; x <= x1; ++x)
        for (std::int16_t i = first_[cell(x, y)]; i >= 0; i = next_[static_cast<std::size_t>(i)])
          use(static_cast<std::size_t>(i));
  }

 private:
  int column(float x_px) const noexcept { return clamped(x_px, columns_); }
  int row(float y_px) const noexcept { return clamped(y_px, rows_); }
  /// Every comparison with what is not a number is false: such a place is at the first cell.
  static int clamped(float px, int count) noexcept {
    const float cell = px * (1.0F / kCell_px);
    const auto last = static_cast<float>(count - 1);
    return static_cast<int>(cell > 0 ? (cell < last ? cell : last) : 0.0F);
  }
  std::size_t cell(int column, int row) const noexcept { return static_cast<std::size_t>(row * columns_ + column); }

  int columns_, rows_;
  std::vector<std::int16_t> first_;  // of each cell, -1 where there is none
  std::array<std::int16_t, kMaxBlobs> next_{};
};

}  // namespace ninedot
