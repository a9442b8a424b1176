#include "detect/region_finder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <tuple>
#include <vector>

namespace ninedot {
namespace {

constexpr std::uint8_t kThreshold = 128;

/// A picture of two grey levels and its threshold picture of half the size.
struct Scene {
  Scene(int width, int height, double dark_share, unsigned seed) : width_px(width), height_px(height) {
    std::mt19937 random(seed);
    std::bernoulli_distribution dark(dark_share);
    pixels.resize(static_cast<std::size_t>(width * height));
    for (std::uint8_t& p : pixels) p = dark(random) ? kThreshold - 1 : kThreshold;
  }
  ImageView view() const { return {pixels.data(), width_px, height_px, width_px}; }
  bool dark(int x, int y) const {
    return x < 2 * (width_px / 2) && pixels[static_cast<std::size_t>(y * width_px + x)] < kThreshold;
  }
  ImageBuffer threshold() const {
    ImageBuffer half(width_px / 2, height_px / 2);
    for (int y = 0; y < half.height_px(); ++y) std::fill_n(half.row(y), half.width_px(), kThreshold);
    return half;
  }

  int width_px, height_px;
  std::vector<std::uint8_t> pixels;
};

/// The same by flood fill, straight from the definition.
std::vector<Region> flood_filled(const Scene& scene, const RegionLimits& limits) {
  std::vector<bool> seen(scene.pixels.size());
  std::vector<Region> regions;
  for (int y0 = 0; y0 < scene.height_px; ++y0) {
    for (int x0 = 0; x0 < scene.width_px; ++x0) {
      if (!scene.dark(x0, y0) || seen[static_cast<std::size_t>(y0 * scene.width_px + x0)]) continue;
      Region r;
      r.min_x = r.min_y = 1 << 20, r.end_x = r.last_y = -1;
      std::vector<std::pair<int, int>> open{{x0, y0}};
      seen[static_cast<std::size_t>(y0 * scene.width_px + x0)] = true;
      while (!open.empty()) {
        const auto [x, y] = open.back();
        open.pop_back();
        ++r.area_px;
        r.min_x = std::min(r.min_x, x), r.end_x = std::max(r.end_x, x + 1);
        r.min_y = std::min(r.min_y, y), r.last_y = std::max(r.last_y, y);
        r.sum_x += x, r.sum_y += y, r.sum_xx += x * x, r.sum_xy += x * y, r.sum_yy += y * y;
        for (int v = std::max(y - 1, 0); v <= std::min(y + 1, scene.height_px - 1); ++v)
          for (int u = std::max(x - 1, 0); u <= std::min(x + 1, scene.width_px - 1); ++u) {
            if (!scene.dark(u, v) || seen[static_cast<std::size_t>(v * scene.width_px + u)]) continue;
            seen[static_cast<std::size_t>(v * scene.width_px + u)] = true;
            open.emplace_back(u, v);
          }
      }
      const bool inside = r.min_x > 0 && r.min_y > 0 && r.end_x < scene.width_px && r.last_y < scene.height_px - 1;
      const int side = std::max(r.end_x - r.min_x, r.last_y - r.min_y + 1);
      if (inside && r.area_px >= limits.min_area_px && side <= limits.max_side_px) regions.push_back(r);
    }
  }
  return regions;
}

auto fields(const Region& r) {
  return std::tuple(r.min_y, r.min_x, r.area_px, r.end_x, r.last_y, r.sum_x, r.sum_y, r.sum_xx, r.sum_xy, r.sum_yy);
}

TEST(RegionFinder, FindsWhatAFloodFillFindsInEveryTexture) {
  RegionFinder finder(200, 200);  // room for every run of the smaller pictures below
  for (unsigned seed = 0; seed < 40; ++seed) {
    for (const double share : {0.02, 0.1, 0.3, 0.4, 0.6, 0.9}) {
      const Scene scene(33 + static_cast<int>(seed * 7 % 65), 8 + static_cast<int>(seed % 50), share, seed);
      const RegionLimits limits{1 + static_cast<int>(seed % 4), seed % 3 == 0 ? 12 : 1000};
      std::vector<Region> expected = flood_filled(scene, limits);
      const auto span = finder.find(scene.view(), scene.threshold(), limits);
      std::vector<Region> found(span.begin(), span.end());
      const auto by_fields = [](const Region& a, const Region& b) { return fields(a) < fields(b); };
      std::sort(expected.begin(), expected.end(), by_fields);
      std::sort(found.begin(), found.end(), by_fields);
      ASSERT_EQ(found.size(), expected.size()) << "seed " << seed << ", share " << share;
      for (std::size_t i = 0; i < found.size(); ++i)
        ASSERT_EQ(fields(found[i]), fields(expected[i])) << "seed " << seed;
    }
  }
}

TEST(RegionFinder, CutsOffATextureWithMoreRunsThanItHasRoomForAndCountsThem) {
  Scene scene(640, 480, 0, 1);
  for (int y = 1; y < 479; ++y)
    for (int x = 1; x < 639; x += 2) scene.pixels[static_cast<std::size_t>(y * 640 + x)] = y % 2 == 1 ? 0 : 255;
  RegionFinder finder(640, 480);
  const auto found = finder.find(scene.view(), scene.threshold(), {1, 60});
  constexpr std::size_t kDrawn = 239 * 319, kRoom = 640 * 480 / 8 + 64;
  EXPECT_EQ(found.size(), kRoom);
  EXPECT_EQ(finder.runs_cut(), kDrawn - kRoom);
  for (const Region& r : found) ASSERT_EQ(r.area_px, 1);
}

}  // namespace
}  // namespace ninedot
