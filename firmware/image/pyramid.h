#pragma once
/// Pictures at half the size, again and again.
#include <array>
#include <cstdint>
#include <vector>

#include "image/image_view.h"

namespace ninedot {

/// A picture with its own memory. Rows start at multiples of 64 bytes and are followed by kPadding_px readable pixels,
/// so that a vector loop may read (and write) past a row's end.
class ImageBuffer {
 public:
  static constexpr int kPadding_px = 64;

  ImageBuffer() = default;
  ImageBuffer(int width_px, int height_px);

  std::uint8_t* row(int y) noexcept { return first_ + y * stride_; }
  const std::uint8_t* row(int y) const noexcept { return first_ + y * stride_; }
  int width_px() const noexcept { return width_px_; }
  int height_px() const noexcept { return height_px_; }
  std::ptrdiff_t stride_bytes() const noexcept { return stride_; }
  ImageView view() const noexcept { return {first_, width_px_, height_px_, stride_}; }
  /// The same memory for a smaller picture, for work on a part of the frame. \param sizes  at most the constructed ones
  /// (contract)
  void resize_within(int width_px, int height_px) noexcept;

 private:
  std::vector<std::uint8_t> bytes_;
  std::uint8_t* first_ = nullptr;
  std::ptrdiff_t stride_ = 0;
  int width_px_ = 0, height_px_ = 0;
};

/// Mean of 2 x 2 pixels, rounded; an odd last column or row is left out.
/// \param out  resized to (width / 2, height / 2) within its own memory
void halve(const ImageView& in, ImageBuffer& out) noexcept;

/// Noise of a picture, from second differences along some rows: 1.4826 median |d2| / sqrt(6). Edges hardly move it.
/// Source: Immerkaer, "Fast Noise Variance Estimation", CVIU 1996, with a median in place of the mean. [grey levels,
/// 1-sigma]
double estimate_noise_lsb(const ImageView& in) noexcept;

}  // namespace ninedot
