// From light to grey levels: noise in linear light, the camera's tone curve, eight bits.
#include <algorithm>
#include <cmath>

#include "base/contract.h"
#include "tests/support/random.h"
#include "tests/support/renderer.h"

namespace ninedot::test {

// IEC 61966-2-1 (sRGB).
double grey_from_light(double light, ToneCurve tone) {
  light = std::clamp(light, 0.0, 1.0);
  if (tone == ToneCurve::kLinear) return 255 * light;
  return 255 * (light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055);
}

double light_from_grey(double grey_lsb, ToneCurve tone) {
  const double value = std::clamp(grey_lsb / 255, 0.0, 1.0);
  if (tone == ToneCurve::kLinear) return value;
  return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
}

void set_noise(Sensor& sensor, double sigma_at_grey128_lsb) {
  const double light = light_from_grey(128, sensor.tone);
  const double light_per_lsb = (light_from_grey(128.5, sensor.tone) - light_from_grey(127.5, sensor.tone));
  const double variance = std::pow(sigma_at_grey128_lsb * light_per_lsb, 2);
  sensor.noise_a = 0.85 * variance / light;
  sensor.noise_b = 0.15 * variance;
}

Picture read_out(const Exposure& exposure, const Sensor& sensor, std::uint64_t seed) {
  EXPECTS(sensor.noise_a >= 0 && sensor.noise_b >= 0);
  Picture picture{exposure.width_px, exposure.height_px, {}};
  picture.pixels.resize(exposure.light.size());
  for (std::size_t i = 0; i < exposure.light.size(); ++i) {
    double light = exposure.light[i];
    const double variance = sensor.noise_a * light + sensor.noise_b;
    if (variance > 0) light += std::sqrt(variance) * random_normal(seed, i);
    picture.pixels[i] = static_cast<std::uint8_t>(grey_from_light(light, sensor.tone) + 0.5);
  }
  return picture;
}

}  // namespace ninedot::test
