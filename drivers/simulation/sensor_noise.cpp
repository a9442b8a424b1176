// Noise is drawn once, for 65536 pixels; each row takes a stretch of it that begins anywhere. That is a hundred times
// faster than to draw it for each pixel, and what two rows share is not seen by anything that looks at neighbours.
#include "drivers/simulation/sensor_noise.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/contract.h"
#include "drivers/simulation/splitmix.h"

namespace ninedot {
namespace {

constexpr std::size_t kLongestRow_px = 8192;  // camera.width_px ends there
constexpr double kShotShare = 0.85;

double grey_from_light(double light) {
  return 255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055);
}

double light_from_grey(double grey_lsb) {
  const double share = grey_lsb / 255;
  return share <= 0.04045 ? share / 12.92 : std::pow((share + 0.055) / 1.055, 2.4);
}

double slope_at(double light) {
  const double step = 1e-4;
  return (grey_from_light(light + step) - grey_from_light(std::max(0.0, light - step))) /
         (light + step - std::max(0.0, light - step));
}

/// Uniform in (0, 1).
double uniform(std::uint64_t seed, std::uint64_t counter) {
  return (static_cast<double>(mixed_bits(seed, counter) >> 12U) + 0.5) * 0x1p-52;
}

}  // namespace

ToneCurve::ToneCurve() {
  // Of the middle of each step.
  for (std::size_t i = 0; i < kSteps; ++i)
    table_.push_back(static_cast<std::uint16_t>(
        std::lround(256 * grey_from_light((static_cast<double>(i) + 0.5) / static_cast<double>(kSteps)))));
}

SensorNoise::SensorNoise(double sigma_lsb, std::uint64_t seed) : seed_(seed) {
  for (std::size_t i = 0; i < (kSamples + kLongestRow_px) / 2; ++i) {
    const double radius = std::sqrt(-2 * std::log(uniform(seed, 2 * i)));
    const double turn = 2 * std::numbers::pi * uniform(seed, 2 * i + 1);
    samples_.push_back(static_cast<std::int16_t>(std::lround(256 * radius * std::cos(turn))));
    samples_.push_back(static_cast<std::int16_t>(std::lround(256 * radius * std::sin(turn))));
  }
  const double middle = light_from_grey(128);
  const double variance = std::pow(sigma_lsb / slope_at(middle), 2);  // in light
  for (std::size_t grey = 0; grey < sigma_256th_.size(); ++grey) {
    const double light = light_from_grey(static_cast<double>(grey));
    const double own = variance * (kShotShare * light / middle + (1 - kShotShare));
    sigma_256th_[grey] = static_cast<std::int32_t>(std::lround(256 * std::sqrt(own) * slope_at(light)));
  }
}

void SensorNoise::read_out(std::span<const std::uint16_t> clean, std::uint64_t row_number,
                           std::uint8_t* noisy) const noexcept {
  EXPECTS(clean.size() <= kLongestRow_px);
  const std::int16_t* samples = samples_.data() + mixed_bits(~seed_, row_number) % kSamples;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    const std::int32_t level = clean[i];
    const std::int32_t read = (level + (samples[i] * sigma_256th_[static_cast<std::size_t>(level >> 8)]) / 256 + 128);
    noisy[i] = static_cast<std::uint8_t>(std::clamp(read / 256, 0, 255));
  }
}

}  // namespace ninedot
