#pragma once
/// A picture with its own memory.
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "image/image_view.h"

namespace ninedot {

/// Rows start at multiples of kAlignment_bytes and are followed by at least kPadding_px readable pixels, so that a
/// vector loop may read (and write) past a row's end. Memory: the constructor's. A moved-from buffer is empty.
class ImageBuffer {
 public:
  /// A cache line of every processor that this runs on, and no less than any vector register.
  static constexpr int kAlignment_bytes = 64;
  /// One vector register of pixels past a row's end, and more than the window that dark_spots.cpp pads a row with.
  static constexpr int kPadding_px = 64;

  ImageBuffer() = default;
  ImageBuffer(int width_px, int height_px);
  ImageBuffer(ImageBuffer&& other) noexcept { *this = std::move(other); }
  ImageBuffer& operator=(ImageBuffer&& other) noexcept;
  // A copy would have to find its own first aligned byte; nobody needs one.
  ImageBuffer(const ImageBuffer&) = delete;
  ImageBuffer& operator=(const ImageBuffer&) = delete;
  ~ImageBuffer() = default;

  std::uint8_t* row(int y) noexcept { return first_ + y * stride_bytes_; }
  const std::uint8_t* row(int y) const noexcept { return first_ + y * stride_bytes_; }
  int width_px() const noexcept { return width_px_; }
  int height_px() const noexcept { return height_px_; }
  std::ptrdiff_t stride_bytes() const noexcept { return stride_bytes_; }
  ImageView view() const noexcept { return {first_, width_px_, height_px_, stride_bytes_}; }
  /// The same memory for a smaller picture, for work on a part of the frame. \param sizes  at most the constructed ones
  /// (contract)
  void resize_within(int width_px, int height_px) noexcept;

 private:
  std::vector<std::uint8_t> bytes_;
  std::uint8_t* first_ = nullptr;  // into bytes_
  std::ptrdiff_t stride_bytes_ = 0;
  int width_px_ = 0, height_px_ = 0;
};

}  // namespace ninedot
