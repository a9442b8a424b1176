#include "image/image_buffer.h"

#include "base/contract.h"

namespace ninedot {

ImageBuffer::ImageBuffer(int width_px, int height_px) : width_px_(width_px), height_px_(height_px) {
  EXPECTS(width_px > 0 && height_px > 0);
  constexpr std::uintptr_t kAlignment = kAlignment_bytes;
  stride_bytes_ = (width_px + 2 * kPadding_px + kAlignment_bytes - 1) / kAlignment_bytes * kAlignment_bytes;
  // One row more than the picture's, for what is read past the last one, and room to move the first to an aligned byte.
  bytes_.assign(static_cast<std::size_t>(stride_bytes_ * (height_px + 1) + kAlignment_bytes), 0);
  const auto beyond = reinterpret_cast<std::uintptr_t>(bytes_.data()) % kAlignment;
  first_ = bytes_.data() + (kAlignment - beyond) % kAlignment;
}

ImageBuffer& ImageBuffer::operator=(ImageBuffer&& other) noexcept {
  if (this == &other) return *this;
  bytes_ = std::move(other.bytes_);  // the same bytes at the same place: first_ stays right
  first_ = std::exchange(other.first_, nullptr);
  stride_bytes_ = std::exchange(other.stride_bytes_, 0);
  width_px_ = std::exchange(other.width_px_, 0);
  height_px_ = std::exchange(other.height_px_, 0);
  other.bytes_.clear();
  return *this;
}

void ImageBuffer::resize_within(int width_px, int height_px) noexcept {
  EXPECTS(width_px + kPadding_px <= stride_bytes_ &&
          stride_bytes_ * (height_px + 1) + kAlignment_bytes <= static_cast<std::ptrdiff_t>(bytes_.size()));
  width_px_ = width_px;
  height_px_ = height_px;
}

}  // namespace ninedot
