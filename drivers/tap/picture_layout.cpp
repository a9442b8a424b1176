#include "drivers/tap/picture_layout.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace ninedot {
namespace {

constexpr std::uint32_t u32(std::ptrdiff_t value) noexcept { return static_cast<std::uint32_t>(value); }

/// Chroma behind `luma_bytes` of luma. Cb and Cr whose samples alternate are one block of rows, else each is one.
void lay_chroma(const ChromaView& chroma, std::size_t luma_bytes, PictureLayout& layout) noexcept {
  TapPicture& picture = layout.picture;
  const std::ptrdiff_t apart = chroma.cr - chroma.cb;
  const bool together = apart > -chroma.step_bytes && apart < chroma.step_bytes;
  const auto rows = static_cast<std::size_t>(chroma.height);
  const auto row_bytes =
      static_cast<std::size_t>((chroma.width - 1) * chroma.step_bytes + 1 + (together ? std::max(apart, -apart) : 0));
  const std::size_t block_bytes = row_bytes * rows;
  layout.blocks[1] = {together ? std::min(chroma.cb, chroma.cr) : chroma.cb, chroma.stride_bytes, row_bytes, rows,
                      luma_bytes};
  if (!together) layout.blocks[2] = {chroma.cr, chroma.stride_bytes, row_bytes, rows, luma_bytes + block_bytes};
  picture.chroma_width = u32(chroma.width);
  picture.chroma_height = u32(chroma.height);
  picture.chroma_step_bytes = u32(chroma.step_bytes);
  picture.chroma_stride_bytes = static_cast<std::uint32_t>(row_bytes);
  picture.cb_offset =
      static_cast<std::uint32_t>(luma_bytes + (together && apart < 0 ? static_cast<std::size_t>(-apart) : 0));
  picture.cr_offset = static_cast<std::uint32_t>(
      luma_bytes + (together ? static_cast<std::size_t>(std::max(apart, std::ptrdiff_t{0})) : block_bytes));
  picture.pixel_bytes = static_cast<std::uint32_t>(luma_bytes + (together ? 1 : 2) * block_bytes);
}

/// End of a plane of samples, 0 where there are none.
std::uint64_t end_of(std::uint64_t offset, std::uint64_t stride, std::uint64_t rows, std::uint64_t row_bytes) noexcept {
  return rows == 0 || row_bytes == 0 ? 0 : offset + stride * (rows - 1) + row_bytes;
}

}  // namespace

PictureLayout picture_layout(const ImageView& luma, const ChromaView& chroma, std::size_t capacity_bytes) noexcept {
  PictureLayout layout;
  if (luma.empty()) return layout;
  const auto width = static_cast<std::size_t>(luma.width_px), height = static_cast<std::size_t>(luma.height_px);
  if (width * height > capacity_bytes) return layout;
  layout.blocks[0] = {luma.pixels, luma.stride_bytes, width, height, 0};
  layout.picture = {.width_px = u32(luma.width_px),
                    .height_px = u32(luma.height_px),
                    .luma_stride_bytes = u32(luma.width_px),
                    .pixel_bytes = static_cast<std::uint32_t>(width * height)};
  if (chroma.empty() || chroma.width <= 0 || chroma.height <= 0) return layout;
  PictureLayout coloured = layout;
  lay_chroma(chroma, width * height, coloured);
  return coloured.picture.pixel_bytes <= capacity_bytes ? coloured : layout;
}

void copy_picture(const PictureLayout& layout, std::byte* to) noexcept {
  for (const PixelRows& block : layout.blocks) {
    std::byte* at = to + block.offset_bytes;
    if (block.stride_bytes == static_cast<std::ptrdiff_t>(block.row_bytes)) {
      if (block.rows > 0) std::memcpy(at, block.from, block.rows * block.row_bytes);
      continue;
    }
    const std::uint8_t* from = block.from;
    for (std::size_t row = 0; row < block.rows; ++row, from += block.stride_bytes, at += block.row_bytes)
      std::memcpy(at, from, block.row_bytes);
  }
}

ImageView luma_of(const TapPicture& picture, const std::uint8_t* pixels) noexcept {
  if (picture.width_px == 0) return {};
  return {pixels, static_cast<int>(picture.width_px), static_cast<int>(picture.height_px),
          static_cast<std::ptrdiff_t>(picture.luma_stride_bytes)};
}

ChromaView chroma_of(const TapPicture& picture, const std::uint8_t* pixels) noexcept {
  if (picture.chroma_width == 0) return {};
  return {pixels + picture.cb_offset,
          pixels + picture.cr_offset,
          static_cast<int>(picture.chroma_width),
          static_cast<int>(picture.chroma_height),
          static_cast<std::ptrdiff_t>(picture.chroma_step_bytes),
          static_cast<std::ptrdiff_t>(picture.chroma_stride_bytes)};
}

bool is_sound(const TapPicture& picture, std::uint64_t capacity_bytes) noexcept {
  constexpr std::uint32_t kMaxSide_px = 8192;  // as the configuration's
  if (picture.width_px > kMaxSide_px || picture.height_px > kMaxSide_px || picture.chroma_width > picture.width_px ||
      picture.chroma_height > picture.height_px || picture.pixel_bytes > capacity_bytes)
    return false;
  const std::uint64_t samples_bytes =
      picture.chroma_width == 0 ? 0 : std::uint64_t{picture.chroma_width - 1} * picture.chroma_step_bytes + 1;
  const auto chroma_end = [&](std::uint32_t offset) {
    return end_of(offset, picture.chroma_stride_bytes, picture.chroma_height, samples_bytes);
  };
  return end_of(0, picture.luma_stride_bytes, picture.height_px, picture.width_px) <= picture.pixel_bytes &&
         std::max(chroma_end(picture.cb_offset), chroma_end(picture.cr_offset)) <= picture.pixel_bytes;
}

}  // namespace ninedot
