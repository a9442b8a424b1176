#pragma once
/// libpng, kept in one place; its jumps out of errors end here. For picture_file.cpp alone.
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/picture/picture_file.h"

namespace ninedot {

bool is_png(std::span<const std::uint8_t> file) noexcept;
Result<PictureSize> read_png_size(std::span<const std::uint8_t> file) noexcept;

/// Into `luma` where the picture is grey, else into `rgb`. \return  whether it has colour
/// \param luma  size.pixel_count() bytes \param rgb  three times that (contract)
Result<bool> decode_png(std::span<const std::uint8_t> file, PictureSize size, std::span<std::uint8_t> luma,
                        std::span<std::uint8_t> rgb) noexcept;

/// \param channels  1 (grey) or 3 (R, G, B) \return  bytes of the file
Result<std::size_t> encode_png(const std::uint8_t* pixels, std::ptrdiff_t stride_bytes, PictureSize size, int channels,
                               std::vector<std::uint8_t>& file);

}  // namespace ninedot
