#pragma once
/// How a camera's pixels lie in a slot of the tap: its luma without gaps, then its chroma rows as the camera has them,
/// planes, pairs or in between the luma, so that each byte is copied once and none is worked on.
#include <array>
#include <cstddef>
#include <cstdint>

#include "image/chroma_view.h"
#include "image/image_view.h"
#include "proto/tap_layout.h"

namespace ninedot {

/// Rows to copy.
struct PixelRows {
  const std::uint8_t* from = nullptr;  ///< grey levels or colour [1]
  std::ptrdiff_t stride_bytes = 0;
  std::size_t row_bytes = 0, rows = 0;
  std::size_t offset_bytes = 0;  ///< of the first row, in the slot's pixels
};

struct PictureLayout {
  TapPicture picture;
  std::array<PixelRows, 3> blocks{};  ///< of no rows where there is less to copy
};

/// Luma, and what chroma takes at most: two planes at every pixel, or rows that hold the luma once more.
/// \param pixel_count  of luma \return  [bytes]
constexpr std::size_t most_picture_bytes(std::size_t pixel_count) noexcept { return 3 * pixel_count; }

/// \param capacity_bytes  of the slot; what does not fit is left out: first the colour, then the picture
/// Memory: none. Threads: pure.
PictureLayout picture_layout(const ImageView& luma, const ChromaView& chroma, std::size_t capacity_bytes) noexcept;

/// \param to  at least layout.picture.pixel_bytes
void copy_picture(const PictureLayout& layout, std::byte* to) noexcept;

/// The other way round, in memory that the caller copied.
/// \param pixels  at least picture.pixel_bytes (contract: is_sound)
ImageView luma_of(const TapPicture& picture, const std::uint8_t* pixels) noexcept;
ChromaView chroma_of(const TapPicture& picture, const std::uint8_t* pixels) noexcept;
/// Whether all that it describes lies within `capacity_bytes`.
bool is_sound(const TapPicture& picture, std::uint64_t capacity_bytes) noexcept;

}  // namespace ninedot
