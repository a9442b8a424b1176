#include "image/bayer_luma.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace ninedot {
namespace {

constexpr int kSide = 32;

/// What a camera makes of a vertical grey edge behind a Bayer pattern (red at even columns and rows): each colour is
/// interpolated by the triangle of two pixels, chroma is averaged over 2 x 2 pixels.
struct Developed {
  std::vector<std::uint8_t> luma, chroma;
  ImageView view() const { return {luma.data(), kSide, kSide, kSide}; }
  ChromaView colours() const { return {chroma.data(), chroma.data() + 1, kSide / 2, kSide / 2, 2, kSide}; }
};

Developed develop(double edge_px) {
  const auto light = [&](int x) { return 60 + 120 * 0.5 * std::erfc((x - edge_px) / (0.6 * std::sqrt(2.0))); };
  std::array<std::vector<double>, 3> colours;
  for (std::size_t c = 0; c < 3; ++c) {
    for (int y = 0; y < kSide; ++y)
      for (int x = 0; x < kSide; ++x) {
        double sum = 0, weights = 0;
        for (int j = -1; j <= 1; ++j)
          for (int i = -1; i <= 1; ++i) {
            const bool odd_x = ((x + i) & 1) != 0, odd_y = ((y + j) & 1) != 0;
            const std::size_t sees = odd_x != odd_y ? 1 : odd_x ? 2 : 0;
            if (sees != c) continue;
            const double weight = (2 - std::abs(i)) * (2 - std::abs(j));
            sum += weight * light(x + i), weights += weight;
          }
        colours[c].push_back(sum / weights);
      }
  }
  Developed made;
  std::vector<double> luma;
  for (std::size_t i = 0; i < colours[0].size(); ++i) {
    luma.push_back(0.299 * colours[0][i] + 0.587 * colours[1][i] + 0.114 * colours[2][i]);
    made.luma.push_back(static_cast<std::uint8_t>(std::lround(luma[i])));
  }
  for (std::size_t y = 0; y < kSide; y += 2)
    for (std::size_t x = 0; x < kSide; x += 2) {
      double cb = 0, cr = 0;
      for (const std::size_t i : {y * kSide + x, y * kSide + x + 1, (y + 1) * kSide + x, (y + 1) * kSide + x + 1})
        cb += 0.564 * (colours[2][i] - luma[i]) / 4, cr += 0.713 * (colours[0][i] - luma[i]) / 4;
      made.chroma.push_back(static_cast<std::uint8_t>(std::lround(128 + cb)));
      made.chroma.push_back(static_cast<std::uint8_t>(std::lround(128 + cr)));
    }
  return made;
}

/// Where the light falls through its middle, on average over the middle rows.
double edge_of(const ImageView& picture) {
  constexpr double kMiddle = 120;
  double sum = 0;
  for (int y = 8; y < kSide - 8; ++y) {
    int x = 4;
    while (picture.at(x + 1, y) > kMiddle) ++x;
    sum += x + (picture.at(x, y) - kMiddle) / (picture.at(x, y) - picture.at(x + 1, y));
  }
  return sum / (kSide - 16);
}

/// By how much what is measured of an edge depends on where it meets the pattern.
struct Swing {
  double least_px = 1, most_px = -1;
  void add(double off_px) { least_px = std::min(least_px, off_px), most_px = std::max(most_px, off_px); }
  double px() const { return most_px - least_px; }
};

TEST(BayerLuma, AnEdgeStaysWhereverItMeetsThePattern) {
  BayerLuma unit(kSide, kSide);
  Swing before, now;
  for (int i = 0; i < 32; ++i) {
    const double edge_px = 15 + i / 16.0;
    const Developed picture = develop(edge_px);
    before.add(edge_of(picture.view()) - edge_px);
    now.add(edge_of(unit.of(picture.view(), picture.colours())) - edge_px);
  }
  EXPECT_GT(before.px(), 0.03) << "the pattern moves nothing: the test shows nothing";
  EXPECT_LT(now.px(), 0.6 * before.px());
}

TEST(BayerLuma, LeavesGreyAsItIsAndAsksNothingOfWhatHasNoColour) {
  BayerLuma unit(kSide, kSide);
  const Developed picture = develop(15.3);
  const ImageView luma = picture.view();
  EXPECT_EQ(unit.of(luma, {}).pixels, luma.pixels);
  ChromaView balanced = picture.colours();
  balanced.luma_is_balanced = true;
  EXPECT_EQ(unit.of(luma, balanced).pixels, luma.pixels);
  EXPECT_EQ(BayerLuma(kSide - 1, kSide).of(luma, picture.colours()).pixels, luma.pixels) << "too large a picture";
  const std::vector<std::uint8_t> no_colour(std::size_t{kSide} * kSide, 128);
  for (const int width : {kSide, kSide / 2, kSide / 4}) {
    const ImageView same = unit.of(luma, {no_colour.data(), no_colour.data(), width, width, 1, width});
    for (int y = 0; y < kSide; ++y) EXPECT_TRUE(std::equal(luma.row(y), luma.row(y) + kSide, same.row(y))) << width;
  }
}

/// Of the sample before a pixel's own, its own, and the one after it, in quarters: three of the nearest, one of the
/// next, or the triangle where each pixel has a sample.
std::array<int, 3> quarters(int at, int block) {
  if (block == 1) return {1, 2, 1};
  return at % block * 2 < block - 1 ? std::array{1, 3, 0} : std::array{0, 3, 1};
}

/// The same pixel by pixel; the border's samples go on beyond it.
int plainly(const ImageView& luma, const ChromaView& chroma, int x, int y) {
  const int across = (luma.width_px + chroma.width - 1) / chroma.width;
  const int down = (luma.height_px + chroma.height - 1) / chroma.height;
  const auto at = [&](int row, int column) {
    const std::ptrdiff_t i = std::ptrdiff_t{std::clamp(row, 0, chroma.height - 1)} * chroma.stride_bytes +
                             std::ptrdiff_t{std::clamp(column, 0, chroma.width - 1)} * chroma.step_bytes;
    return 32 * (chroma.cb[i] - 128) - 6 * (chroma.cr[i] - 128);
  };
  const auto mean = [](const std::array<int, 3>& weights, auto&& value) {
    return (weights[0] * value(-1) + weights[1] * value(0) + weights[2] * value(1) + 2) >> 2;
  };
  const int spread = mean(quarters(x, across), [&](int i) {
    return mean(quarters(y, down), [&](int j) { return at(y / down + j, x / across + i); });
  });
  return std::clamp(luma.at(x, y) + ((spread + 32) >> 6), 0, 255);
}

TEST(BayerLuma, IsTheSameForEveryLayoutAndSize) {
  std::uint32_t state = 1;
  const auto noise = [&] { return static_cast<std::uint8_t>((state = state * 1664525U + 1013904223U) >> 24); };
  for (const int width : {2, 7, 16, 33, 50, 64})
    for (const int height : {2, 5, 12})
      for (const int across : {1, 2, 4})
        for (const int down : {1, 2, 4})
          for (const int step : {1, 2, 4}) {
            const int columns = (width + across - 1) / across, rows = (height + down - 1) / down;
            if ((width + columns - 1) / columns != across || (height + rows - 1) / rows != down) continue;
            const int stride = columns * step + 3;
            std::vector<std::uint8_t> luma(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
            std::vector<std::uint8_t> planes(2 * static_cast<std::size_t>(stride) * static_cast<std::size_t>(rows));
            std::ranges::generate(luma, noise);
            std::ranges::generate(planes, noise);
            const std::uint8_t* cb = planes.data();
            const std::uint8_t* beside = step == 1 ? cb + std::ptrdiff_t{stride} * rows : cb + step / 2;
            BayerLuma unit(64, 12);
            const ImageView view{luma.data(), width, height, width};
            for (const bool is_cb_first : {true, false}) {
              const ChromaView chroma{
                  is_cb_first ? cb : beside, is_cb_first ? beside : cb, columns, rows, step, stride};
              const ImageView got = unit.of(view, chroma);
              for (int y = 0; y < height; ++y)
                for (int x = 0; x < width; ++x)
                  ASSERT_EQ(got.at(x, y), plainly(view, chroma, x, y))
                      << width << " x " << height << ", blocks of " << across << " x " << down << ", step " << step
                      << ", at " << x << ", " << y;
            }
          }
}

}  // namespace
}  // namespace ninedot
