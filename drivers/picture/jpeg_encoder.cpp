#include "drivers/picture/jpeg_encoder.h"

#include <turbojpeg.h>

#include <algorithm>
#include <array>

#include "base/contract.h"

namespace ninedot {

JpegEncoder::JpegEncoder() : jpeg_(tjInitCompress()) {}
JpegEncoder::~JpegEncoder() {
  if (jpeg_ != nullptr) tjDestroy(jpeg_);
}

Result<std::span<const std::uint8_t>> JpegEncoder::encode(const ImageView& luma, const ChromaView& chroma,
                                                          int quality) {
  EXPECTS(!luma.empty());
  const int subsampling = chroma.empty() ? TJSAMP_GRAY : TJSAMP_420;
  const int half_width = (luma.width_px + 1) / 2, half_height = (luma.height_px + 1) / 2;
  if (!chroma.empty()) {
    const auto size = static_cast<std::size_t>(half_width) * static_cast<std::size_t>(half_height);
    cb_.resize(size), cr_.resize(size);
    // The nearest sample: what is shown is for eyes.
    const auto nearest = [](int at, int count, int samples) { return std::min(at * samples / count, samples - 1); };
    std::size_t to = 0;
    for (int y = 0; y < half_height; ++y) {
      const int from_y = nearest(y, half_height, chroma.height);
      for (int x = 0; x < half_width; ++x, ++to) {
        const int from_x = nearest(x, half_width, chroma.width);
        cb_[to] = chroma.cb_at(from_x, from_y);
        cr_[to] = chroma.cr_at(from_x, from_y);
      }
    }
  }
  const bool is_padded = !chroma.empty() && (luma.width_px % 2 != 0 || luma.height_px % 2 != 0);
  if (is_padded) pad(luma);
  file_.resize(tjBufSize(luma.width_px, luma.height_px, subsampling));
  const std::array<const unsigned char*, 3> planes{is_padded ? padded_.data() : luma.pixels, cb_.data(), cr_.data()};
  const std::array<int, 3> strides{is_padded ? 2 * half_width : static_cast<int>(luma.stride_bytes), half_width,
                                   half_width};
  unsigned char* file = file_.data();
  auto size = static_cast<unsigned long>(file_.size());
  if (jpeg_ == nullptr || tjCompressFromYUVPlanes(jpeg_, const_cast<const unsigned char**>(planes.data()),
                                                  luma.width_px, strides.data(), luma.height_px, subsampling, &file,
                                                  &size, quality, TJFLAG_NOREALLOC | TJFLAG_FASTDCT) != 0)
    return fail(Errc::kIo, "libturbojpeg could not encode the picture");
  return std::span<const std::uint8_t>(file_.data(), size);
}

/// With samples for each two by two pixels libturbojpeg reads an even number of pixels and rows: the last ones again.
void JpegEncoder::pad(const ImageView& luma) {
  const int width = luma.width_px + luma.width_px % 2, height = luma.height_px + luma.height_px % 2;
  padded_.clear();
  for (int y = 0; y < height; ++y) {
    const std::uint8_t* row = luma.row(std::min(y, luma.height_px - 1));
    padded_.insert(padded_.end(), row, row + luma.width_px);
    if (width != luma.width_px) padded_.push_back(row[luma.width_px - 1]);
  }
}

}  // namespace ninedot
