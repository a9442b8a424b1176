#pragma once
/// The colour of a picture that somebody else owns.
#include <cstddef>
#include <cstdint>

namespace ninedot {

/// One Cb and one Cr for each block of luma pixels, as the camera's buffer holds them: planes, pairs, or between the
/// luma. 128 is no colour. The blocks are (luma width / width) by (luma height / height) pixels, rounded up. Where in
/// its block a sample was taken (centre or left edge) is not told. Lifetime: as of the luma that it came with.
///
/// The equations are ITU-R BT.601's. Luma and chroma are both as the source gives them, so they always fit together,
/// but their range is the source's:
///
/// | source | range |
/// |---|---|
/// | pictures and JPEG files of a recording | full: 0..255 for both, Cb = 128 + 0.564 (B - Y), Cr = 128 + 0.713 (R - Y)
/// | | cameras, .y4m files | not known here; most are limited: luma 16..235, chroma 16..240, which is 219/255 and
/// 224/255 of the full range |
///
/// So the hue is right everywhere, and saturation beside contrast is right to within 2.3 % (224/219); absolute levels
/// are not comparable between sources. A recording of a camera keeps the camera's numbers, whatever their range.
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
