#include "detect/blob_grid.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace ninedot {
namespace {

TEST(BlobGrid, MissesNoBlobWithinReachAndNamesNoneTwice) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> x(-5, 645), y(-5, 485), reach(0, 90);
  BlobList blobs;
  while (blobs.try_push_back(Blob{x(random), y(random), 10, 1, 0, 1, 0})) {
  }
  BlobGrid grid(640, 480);
  grid.build(blobs.span());
  for (int query = 0; query < 300; ++query) {
    const float at_x = x(random), at_y = y(random), reach_px = reach(random);
    std::vector<std::size_t> named;
    grid.for_each_near(at_x, at_y, reach_px, [&](std::size_t i) { named.push_back(i); });
    std::sort(named.begin(), named.end());
    EXPECT_EQ(std::adjacent_find(named.begin(), named.end()), named.end());
    for (std::size_t i = 0; i < blobs.size(); ++i) {
      const bool near = std::abs(blobs[i].x_px - at_x) <= reach_px && std::abs(blobs[i].y_px - at_y) <= reach_px;
      ASSERT_TRUE(!near || std::binary_search(named.begin(), named.end(), i)) << i;
    }
    EXPECT_LT(named.size(), blobs.size());
  }
}

TEST(BlobGrid, ForgetsWhatWasThereBefore) {
  BlobList blobs;
  ASSERT_TRUE(blobs.try_push_back(Blob{100, 100, 10, 1, 0, 1, 0}));
  BlobGrid grid(640, 480);
  grid.build(blobs.span());
  grid.build({});
  grid.for_each_near(100, 100, 50, [](std::size_t) { FAIL(); });
}

TEST(BlobGrid, StaysWithinItsCellsWhateverTheNumbersAre) {
  constexpr float kNaN = std::numeric_limits<float>::quiet_NaN(), kInfinity = std::numeric_limits<float>::infinity();
  BlobGrid grid(640, 480);
  for (const float x_px : {kNaN, kInfinity, -kInfinity, 3e38F, 320.0F})
    for (const float y_px : {kNaN, kInfinity, -kInfinity, -3e38F, 240.0F}) {
      BlobList blobs;
      ASSERT_TRUE(blobs.try_push_back(Blob{x_px, y_px, 10, 1, 0, 1, 0}));
      grid.build(blobs.span());
      int named = 0;
      for (const float reach_px : {kNaN, kInfinity, 1.0F})
        grid.for_each_near(x_px, y_px, reach_px, [&](std::size_t i) { named += i == 0 ? 1 : 1000; });
      EXPECT_LE(named, 3) << x_px << ' ' << y_px;
    }
}

}  // namespace
}  // namespace ninedot
