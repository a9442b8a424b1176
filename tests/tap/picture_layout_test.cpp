#include "drivers/tap/picture_layout.h"

#include <gtest/gtest.h>

#include <random>

namespace ninedot {
namespace {

/// The last byte that a reader of this picture touches, by walking over every sample's corners.
std::uint64_t furthest_byte(const TapPicture& p) {
  const std::uint8_t* const start = nullptr;
  std::uint64_t furthest = 0;
  const auto touch = [&](std::uint64_t offset) { furthest = std::max(furthest, offset + 1); };
  for (const std::uint64_t y : {std::uint64_t{0}, std::uint64_t{p.height_px} - 1})
    if (p.height_px > 0 && p.width_px > 0) touch(y * p.luma_stride_bytes + p.width_px - 1);
  if (p.chroma_width > 0 && p.chroma_height > 0)
    for (const std::uint64_t offset : {p.cb_offset, p.cr_offset})
      touch(offset + (std::uint64_t{p.chroma_height} - 1) * p.chroma_stride_bytes +
            (std::uint64_t{p.chroma_width} - 1) * p.chroma_step_bytes);
  static_cast<void>(start);
  return furthest;
}

TEST(PictureLayout, ThatIsSoundLeadsNowhereElse) {
  std::mt19937 random(20260101);
  const auto number = [&](std::uint32_t most) {
    // Small ones, and the ends where sums wrap.
    switch (random() % 8) {
      case 0:
        return ~std::uint32_t{0} - static_cast<std::uint32_t>(random() % 3);
      case 1:
        return std::uint32_t{0};
      default:
        return static_cast<std::uint32_t>(random() % most);
    }
  };
  int sound = 0;
  for (int i = 0; i < 300000; ++i) {
    const TapPicture p{.width_px = number(100),
                       .height_px = number(100),
                       .luma_stride_bytes = number(120),
                       .chroma_width = number(60),
                       .chroma_height = number(60),
                       .chroma_step_bytes = number(5),
                       .chroma_stride_bytes = number(130),
                       .cb_offset = number(8000),
                       .cr_offset = number(8000),
                       .pixel_bytes = number(20000)};
    if (!is_sound(p, 20000)) continue;
    ++sound;
    ASSERT_LE(furthest_byte(p), p.pixel_bytes);
    ASSERT_LE(p.pixel_bytes, 20000U);
  }
  EXPECT_GT(sound, 1000);
}

TEST(PictureLayout, OfWhatWasLaidOutIsSound) {
  const std::vector<std::uint8_t> bytes(40000);
  const ImageView luma{bytes.data(), 64, 48, 70};
  const ChromaView chroma{bytes.data() + 1, bytes.data() + 3, 32, 48, 4, 140};
  for (const std::size_t capacity : {std::size_t{0}, std::size_t{3072}, std::size_t{5000}, most_picture_bytes(3072)}) {
    const PictureLayout layout = picture_layout(luma, chroma, capacity);
    EXPECT_TRUE(is_sound(layout.picture, capacity));
    EXPECT_EQ(layout.picture.width_px, capacity < 3072 ? 0U : 64U);
    EXPECT_EQ(layout.picture.chroma_width, capacity < 9000 ? 0U : 32U) << "the colour goes first";
  }
}

}  // namespace
}  // namespace ninedot
