/// Whatever a picture file or a .y4m header holds: an error or a picture, and no byte outside of the buffers. The first
/// byte chooses how it is read.
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/contract.h"
#include "drivers/capture/picture_file.h"
#include "drivers/capture/y4m_file.h"

namespace {

// Small, so that the address sanitizer checks short rows; the corpus's pictures are of this size.
constexpr ninedot::PictureSize kSize{8, 6};

void decode(std::span<const std::uint8_t> file, bool with_colour) {
  using namespace ninedot;
  static PictureDecoder decoder(kSize);
  std::array<std::uint8_t, 8 * 6> luma{};
  std::array<std::uint8_t, 3 * 8 * 6> rgb{};
  const auto size = decoder.decode(file, luma, with_colour ? std::span<std::uint8_t>(rgb) : std::span<std::uint8_t>());
  EXPECTS(!size || *size == kSize);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace ninedot;
  if (size < 1) return 0;
  const std::span<const std::uint8_t> file(bytes + 1, size - 1);
  if (bytes[0] % 4 < 2) {
    (void)read_picture_size(file);
    decode(file, bytes[0] % 2 == 1);
  } else if (bytes[0] % 4 == 2) {
    const auto header = parse_y4m_header(file);
    if (header) EXPECTS(header->header_bytes <= file.size() && header->size.width_px > 0);
  } else {
    const auto length = parse_y4m_frame_header(file);
    if (length) EXPECTS(*length <= file.size());
  }
  return 0;
}
