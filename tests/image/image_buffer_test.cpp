#include "image/image_buffer.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <type_traits>
#include <utility>

namespace ninedot {
namespace {

static_assert(!std::is_copy_constructible_v<ImageBuffer> && !std::is_copy_assignable_v<ImageBuffer>,
              "a copy's rows would lie in the original's memory");
static_assert(std::is_nothrow_move_constructible_v<ImageBuffer> && std::is_nothrow_move_assignable_v<ImageBuffer>);

TEST(ImageBuffer, BeginsEveryRowAtACacheLineAndHasRoomBehindIt) {
  for (const int width_px : {1, 63, 64, 65, 640}) {
    ImageBuffer buffer(width_px, 3);
    for (int y = 0; y < 3; ++y) {
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(buffer.row(y)) % ImageBuffer::kAlignment_bytes, 0U);
      for (int x = 0; x < width_px + ImageBuffer::kPadding_px; ++x) buffer.row(y)[x] = 1;
    }
    EXPECT_GE(buffer.stride_bytes(), width_px + ImageBuffer::kPadding_px);
  }
}

TEST(ImageBuffer, TakesItsPixelsAlongWhenItMoves) {
  ImageBuffer first(30, 20);
  first.row(7)[11] = 99;
  const std::uint8_t* place = first.row(7);
  ImageBuffer second(std::move(first));
  EXPECT_EQ(second.row(7), place);
  EXPECT_TRUE(first.view().empty());  // NOLINT: moved from, and says so
  ImageBuffer third(5, 5);
  third = std::move(second);
  EXPECT_EQ(third.row(7)[11], 99);
  EXPECT_EQ(third.width_px(), 30);
  EXPECT_TRUE(second.view().empty());  // NOLINT
}

}  // namespace
}  // namespace ninedot
