#pragma once
/// Grey paper with noise, for tests.
#include <algorithm>
#include <cstdint>
#include <random>
#include <vector>

namespace ninedot::test {

/// Mean 128; the bytes between a row's end and the next row are 255.
inline std::vector<std::uint8_t> noise_picture(int width_px, int height_px, int stride_bytes, double sigma_lsb) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(128, sigma_lsb);
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(stride_bytes * height_px), 255);
  for (int y = 0; y < height_px; ++y)
    for (int x = 0; x < width_px; ++x)
      pixels[static_cast<std::size_t>(y * stride_bytes + x)] =
          static_cast<std::uint8_t>(std::clamp(noise(random), 0.0, 255.0));
  return pixels;
}

}  // namespace ninedot::test
