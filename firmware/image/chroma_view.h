#pragma once
/// The colour of a picture that somebody else owns.
#include <cstddef>
#include <cstdint>

namespace ninedot {

/// One Cb and one Cr for each block of luma pixels, as the camera's buffer holds them: planes, pairs, or between the
/// luma. 128 is no colour. The blocks are (luma width / width) by (luma height / height) pixels, rounded up. Lifetime:
/// as of the luma that it came with.
struct ChromaView {
  const std::uint8_t* cb = nullptr;
  const std::uint8_t* cr = nullptr;
  int width = 0, height = 0;        ///< [samples]
  std::ptrdiff_t step_bytes = 0;    ///< from one sample to the next in its row
  std::ptrdiff_t stride_bytes = 0;  ///< from one row to the next

  std::uint8_t cb_at(int x, int y) const noexcept { return cb[y * stride_bytes + x * step_bytes]; }
  std::uint8_t cr_at(int x, int y) const noexcept { return cr[y * stride_bytes + x * step_bytes]; }
  bool empty() const noexcept { return cb == nullptr || cr == nullptr; }
};

}  // namespace ninedot
