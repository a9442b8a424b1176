// PNG, PNM and JPEG: the size from the header, then the whole picture into exactly as much memory as that size asks
// for.
#include <vector>

#include "base/contract.h"
#include "drivers/picture/picture_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t count) {
  using namespace ninedot;
  const std::span<const std::uint8_t> file(bytes, count);
  const Result<PictureSize> size = read_picture_size(file);
  if (!size || size->pixel_count() > 1U << 20U) return 0;
  std::vector<std::uint8_t> luma(size->pixel_count()), rgb(3 * size->pixel_count());
  PictureDecoder decoder(*size);
  const bool decoded = decoder.decode(file, luma, rgb).has_value();
  EXPECTS(decoder.decode(file, luma).has_value() == decoded);  // the colour wanted or not, the answer is the same
  std::vector<std::uint8_t> same_luma(luma.size()), planes(2 * luma.size());
  const Result<ChromaView> chroma = decoder.decode_with_chroma(file, same_luma, planes);
  if (decoded && chroma) EXPECTS(same_luma == luma);
  if (chroma && !chroma->empty()) {
    EXPECTS(chroma->width <= size->width_px && chroma->height <= size->height_px);
    rgb_from_ycbcr({luma.data(), size->width_px, size->height_px, size->width_px}, *chroma, rgb);
    for (std::size_t i = 0; decoded && i < luma.size(); ++i)
      EXPECTS(luma_from_rgb(rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]) == luma[i]);
  }

  PictureDecoder other({size->width_px + 1, size->height_px});
  luma.resize(luma.size() + static_cast<std::size_t>(size->height_px));
  EXPECTS(!other.decode(file, luma));
  return 0;
}
