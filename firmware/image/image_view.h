#pragma once
/// Pictures that somebody else owns.
#include <cstddef>
#include <cstdint>

namespace ninedot {

/// 8-bit luma, row by row, any stride. Pixel centres have integer coordinates: x right, y down, (0, 0) top left.
/// Lifetime: the pixels outlive the view; the view never frees them.
struct ImageView {
  const std::uint8_t* pixels = nullptr;
  int width_px = 0;
  int height_px = 0;
  std::ptrdiff_t stride_bytes = 0;  ///< from one row to the next, >= width_px
  bool has_pattern = false;  ///< interpolated from a colour camera's pattern: sharper at some pixels than at others

  const std::uint8_t* row(int y) const noexcept { return pixels + y * stride_bytes; }
  /// \return  the grey level [LSB]
  std::uint8_t at(int x, int y) const noexcept { return row(y)[x]; }
  bool empty() const noexcept { return pixels == nullptr || width_px <= 0 || height_px <= 0; }
  bool contains(int x, int y) const noexcept { return x >= 0 && y >= 0 && x < width_px && y < height_px; }
};

}  // namespace ninedot
