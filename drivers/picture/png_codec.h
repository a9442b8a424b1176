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

/// \param scratch_rgb  3 * size.pixel_count() bytes for colour pictures whose colour the caller does not want
Result<PictureSize> decode_png(std::span<const std::uint8_t> file, PictureSize size, std::span<std::uint8_t> luma,
                               std::span<std::uint8_t> rgb, std::uint8_t* scratch_rgb) noexcept;

/// \param channels  1 (grey) or 3 (R, G, B)
Result<std::size_t> encode_png(const std::uint8_t* pixels, std::ptrdiff_t stride_bytes, PictureSize size, int channels,
                               std::vector<std::uint8_t>& file);

}  // namespace ninedot
