#include "tests/support/renderer_cover.h"

#include <Eigen/LU>
#include <cstdint>

#include "tests/support/random.h"

namespace ninedot::test {
namespace {

// Smooth noise in [-1, 1]: random values at the corners of a square lattice, three octaves.
double lattice_noise(double x, double y, std::uint64_t seed) {
  const double x0 = std::floor(x), y0 = std::floor(y);
  const auto corner = [&](double i, double j) {
    const auto key = static_cast<std::uint64_t>(static_cast<std::int64_t>(i)) * 0x1F123BB5ULL +
                     static_cast<std::uint64_t>(static_cast<std::int64_t>(j)) * 0x9E3779B1ULL;
    return 2 * random_uniform(seed, key) - 1;
  };
  const auto ease = [](double t) { return t * t * (3 - 2 * t); };
  const double fx = ease(x - x0), fy = ease(y - y0);
  const double top = corner(x0, y0) + fx * (corner(x0 + 1, y0) - corner(x0, y0));
  const double bottom = corner(x0, y0 + 1) + fx * (corner(x0 + 1, y0 + 1) - corner(x0, y0 + 1));
  return top + fy * (bottom - top);
}

}  // namespace

double textured(const Texture& texture, const Spot& spot) {
  if (texture.contrast <= 0) return texture.reflectance;
  double sum = 0, amplitude = 1, grain_m = texture.grain_m;
  const double pixel_m = std::sqrt(std::abs(spot.per_px.determinant()));
  for (int octave = 0; octave < 3 && grain_m > 2 * pixel_m; ++octave) {
    sum += amplitude * lattice_noise(spot.at_m.x() / grain_m, spot.at_m.y() / grain_m,
                                     texture.seed + static_cast<unsigned>(octave));
    amplitude /= 2, grain_m /= 2;
  }
  return std::clamp(texture.reflectance * (1 + texture.contrast * sum), 0.0, 1.0);
}

}  // namespace ninedot::test
