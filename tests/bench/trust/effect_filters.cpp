// Filters of 8-bit pictures, as cameras apply them.
#include <turbojpeg.h>

#include <algorithm>
#include <cmath>

#include "base/contract.h"
#include "tests/bench/trust/effects.h"

namespace ninedot::bench {
namespace {

// level(x, y) -> the pixel's new level.
template <typename Level>
test::Picture filtered(const test::Picture& picture, const Level& level) {
  test::Picture result{picture.width_px, picture.height_px, {}};
  result.pixels.reserve(picture.pixels.size());
  for (int y = 0; y < picture.height_px; ++y)
    for (int x = 0; x < picture.width_px; ++x)
      result.pixels.push_back(static_cast<std::uint8_t>(std::clamp(level(x, y) + 0.5, 0.0, 255.0)));
  return result;
}

int level_at(const test::Picture& picture, int x, int y) {
  return picture.view().at(std::clamp(x, 0, picture.width_px - 1), std::clamp(y, 0, picture.height_px - 1));
}

}  // namespace

test::Picture through_jpeg(const test::Picture& picture, int quality) {
  unsigned char* file = nullptr;
  unsigned long bytes = 0;
  const tjhandle encoder = tjInitCompress(), decoder = tjInitDecompress();
  test::Picture result{picture.width_px, picture.height_px, std::vector<std::uint8_t>(picture.pixels.size())};
  const bool done = tjCompress2(encoder, picture.pixels.data(), picture.width_px, 0, picture.height_px, TJPF_GRAY,
                                &file, &bytes, TJSAMP_GRAY, quality, 0) == 0 &&
                    tjDecompress2(decoder, file, bytes, result.pixels.data(), picture.width_px, 0, picture.height_px,
                                  TJPF_GRAY, 0) == 0;
  tjFree(file);
  tjDestroy(encoder), tjDestroy(decoder);
  EXPECTS(done);
  return result;
}

test::Picture sharpened(const test::Picture& picture, double amount) {
  constexpr std::array<double, 3> kWeights{0.40262, 0.24420, 0.05449};  // exp(-d^2 / 2), over their sum
  const auto weight = [&](int d) { return kWeights[static_cast<std::size_t>(std::abs(d))]; };
  return filtered(picture, [&](int x, int y) {
    double blurred = 0;
    for (int dy = -2; dy <= 2; ++dy)
      for (int dx = -2; dx <= 2; ++dx) blurred += weight(dx) * weight(dy) * level_at(picture, x + dx, y + dy);
    const double level = level_at(picture, x, y);
    return level + amount * (level - blurred);
  });
}

test::Picture median_of_nine(const test::Picture& picture) {
  return filtered(picture, [&](int x, int y) {
    std::array<int, 9> levels{};
    for (int i = 0; i < 9; ++i) levels[static_cast<std::size_t>(i)] = level_at(picture, x + i % 3 - 1, y + i / 3 - 1);
    std::nth_element(levels.begin(), levels.begin() + 4, levels.end());
    return static_cast<double>(levels[4]);
  });
}

test::Picture bilateral(const test::Picture& picture, double sigma_px, double sigma_lsb) {
  std::array<double, 256> by_level{};
  for (std::size_t i = 0; i < by_level.size(); ++i)
    by_level[i] = std::exp(-static_cast<double>(i * i) / (2 * sigma_lsb * sigma_lsb));
  std::array<double, 9> by_place{};  // index: square of the distance
  for (std::size_t i = 0; i < by_place.size(); ++i)
    by_place[i] = std::exp(-static_cast<double>(i) / (2 * sigma_px * sigma_px));
  return filtered(picture, [&](int x, int y) {
    const int middle = level_at(picture, x, y);
    double sum = 0, weights = 0;
    for (int dy = -2; dy <= 2; ++dy)
      for (int dx = -2; dx <= 2; ++dx) {
        const int level = level_at(picture, x + dx, y + dy);
        const double weight = by_place[static_cast<std::size_t>(dx * dx + dy * dy)] *
                              by_level[static_cast<std::size_t>(std::abs(level - middle))];
        sum += weight * level, weights += weight;
      }
    return sum / weights;
  });
}

}  // namespace ninedot::bench
