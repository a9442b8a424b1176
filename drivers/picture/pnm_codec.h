#pragma once
/// Binary PGM (P5) and PPM (P6) with 8 bits per sample. Netpbm's own pages pgm(5) and ppm(5) are the specification.
#include <cstdint>
#include <span>

#include "drivers/picture/picture_file.h"

namespace ninedot {

bool is_pnm(std::span<const std::uint8_t> file) noexcept;

struct PnmHeader {
  PictureSize size;
  int channels = 1;
  std::size_t pixels_at = 0;  ///< offset of the first sample
};
/// \error kFrameUnreadable
Result<PnmHeader> read_pnm_header(std::span<const std::uint8_t> file) noexcept;

/// Into `luma` where the picture is grey, else into `rgb`. \return  whether it has colour
/// \param luma  size.pixel_count() bytes \param rgb  three times that (contract)
Result<bool> decode_pnm(std::span<const std::uint8_t> file, PictureSize size, std::span<std::uint8_t> luma,
                        std::span<std::uint8_t> rgb) noexcept;

}  // namespace ninedot
