#include "tests/support/colour_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/contract.h"
#include "tests/support/random.h"

namespace ninedot::test {
namespace {

using Channel = double LinearRgb::*;
constexpr std::array<Channel, 3> kChannels{&LinearRgb::red, &LinearRgb::green, &LinearRgb::blue};

Exposure expose_channel(const ColourScene& scene, Channel channel) {
  Scene grey = scene.scene;
  Sheet& sheet = grey.sheets.front();
  EXPECTS(scene.discs.size() == sheet.discs.size());
  sheet.reflectance = scene.paper.*channel;
  for (std::size_t i = 0; i < sheet.discs.size(); ++i)
    sheet.discs[i].reflectance = scene.discs[i].*channel * (1 - scene.fade) + sheet.reflectance * scene.fade;
  grey.light.level *= scene.light.*channel;
  return expose(grey);
}

/// Which colour a pixel measures: 0 red, 1 green, 2 blue.
int measured_at(int x, int y) { return y % 2 == 0 ? (x % 2 == 0 ? 0 : 1) : (x % 2 == 0 ? 1 : 2); }

/// Bilinear: the mean of what neighbours and the pixel itself measured of a colour, weights 1 2 1 each way.
double interpolated(const std::vector<double>& mosaic, int width, int height, int x, int y, int colour) {
  double sum = 0, weights = 0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const int u = x + dx, v = y + dy;
      if (u < 0 || v < 0 || u >= width || v >= height || measured_at(u, v) != colour) continue;
      const double weight = (2 - std::abs(dx)) * (2 - std::abs(dy));
      sum += weight * mosaic[static_cast<std::size_t>(v * width + u)], weights += weight;
    }
  return sum / weights;
}

std::uint8_t eight_bits(double level) { return static_cast<std::uint8_t>(std::clamp(level + 0.5, 0.0, 255.0)); }

}  // namespace

LinearRgb linear_of_srgb(int red, int green, int blue) {
  return {light_from_grey(red, ToneCurve::kSrgb), light_from_grey(green, ToneCurve::kSrgb),
          light_from_grey(blue, ToneCurve::kSrgb)};
}

LinearRgb light_of_kelvin(double kelvin, double balanced_for_kelvin) {
  constexpr double kSecondConstant_mK = 0.014388;  // h c / k
  const auto relative = [&](double wavelength_m) {
    const auto radiance = [&](double T) { return 1 / std::expm1(kSecondConstant_mK / (wavelength_m * T)); };
    return radiance(kelvin) / radiance(balanced_for_kelvin);
  };
  const double green = relative(545e-9);
  return {relative(610e-9) / green, 1, relative(465e-9) / green};
}

ColourPicture render_colour(const ColourScene& scene, ChromaLayout layout, std::uint64_t seed) {
  ColourExposure exposure;
  for (std::size_t c = 0; c < exposure.size(); ++c) exposure[c] = expose_channel(scene, kChannels[c]);
  return read_out(exposure, scene.scene.sensor, layout, seed);
}

ColourPicture read_out(const ColourExposure& exposure, const Sensor& sensor, ChromaLayout layout, std::uint64_t seed) {
  const int width = exposure[0].width_px, height = exposure[0].height_px;
  EXPECTS(width % 2 == 0 && height % 2 == 0);
  std::vector<double> mosaic(exposure[0].light.size());
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto i = static_cast<std::size_t>(y * width + x);
      const double light = exposure[static_cast<std::size_t>(measured_at(x, y))].light[i];
      mosaic[i] = light + std::sqrt(sensor.noise_a * light + sensor.noise_b) * random_normal(seed, i);
    }

  ColourPicture picture;
  picture.luma = {width, height, std::vector<std::uint8_t>(mosaic.size())};
  const int columns = layout == ChromaLayout::k444 ? 1 : 2, rows = layout == ChromaLayout::k420 ? 2 : 1;
  picture.chroma_width = width / columns, picture.chroma_height = height / rows;
  std::vector<double> chroma(static_cast<std::size_t>(2 * picture.chroma_width * picture.chroma_height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      std::array<double, 3> level;
      for (int c = 0; c < 3; ++c)
        level[static_cast<std::size_t>(c)] = grey_from_light(interpolated(mosaic, width, height, x, y, c), sensor.tone);
      const double luma = 0.299 * level[0] + 0.587 * level[1] + 0.114 * level[2];
      picture.luma.pixels[static_cast<std::size_t>(y * width + x)] = eight_bits(luma);
      const auto sample = static_cast<std::size_t>(2 * (y / rows * picture.chroma_width + x / columns));
      chroma[sample] += 0.564 * (level[2] - luma) / (columns * rows);
      chroma[sample + 1] += 0.713 * (level[0] - luma) / (columns * rows);
    }
  picture.chroma_bytes.reserve(chroma.size());
  for (const double value : chroma) picture.chroma_bytes.push_back(eight_bits(128 + value));
  return picture;
}

}  // namespace ninedot::test
