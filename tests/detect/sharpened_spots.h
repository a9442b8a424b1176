#pragma once
/// A picture that cameras with a sharpening filter make: dark pixels that stand alone.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

namespace ninedot::test {

/// 640 x 480: random spots of 1 to 4 pixels on nearly smooth paper, sharpened by 150 %.
inline std::vector<std::uint8_t> sharpened_spots(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 1);
  std::uniform_int_distribution<int> x(3, 636), y(3, 476), side(1, 4), depth(40, 160);
  std::vector<double> light(640 * 480);
  for (double& l : light) l = 170 + noise(random);
  for (int spot = 0; spot < 1500; ++spot) {
    const int x0 = x(random), y0 = y(random), width = side(random), height = side(random), d = depth(random);
    for (int v = y0; v < std::min(y0 + height, 480); ++v)
      for (int u = x0; u < std::min(x0 + width, 640); ++u) light[static_cast<std::size_t>(v * 640 + u)] -= d;
  }
  std::vector<std::uint8_t> pixels(640 * 480);
  for (int v = 0; v < 480; ++v)
    for (int u = 0; u < 640; ++u) {
      const auto at = [&](int dx, int dy) {
        return light[static_cast<std::size_t>(std::clamp(v + dy, 0, 479) * 640 + std::clamp(u + dx, 0, 639))];
      };
      const double around = (at(-1, 0) + at(1, 0) + at(0, -1) + at(0, 1)) / 4;
      pixels[static_cast<std::size_t>(v * 640 + u)] =
          static_cast<std::uint8_t>(std::clamp(std::lround(at(0, 0) + 1.5 * (at(0, 0) - around)), 0L, 255L));
    }
  return pixels;
}

}  // namespace ninedot::test
