// Surfaces.
#include <cmath>
#include <numbers>

#include "tests/bench/trust/near_misses.h"

namespace ninedot::bench {
namespace {

constexpr double kTurn_rad = 2 * std::numbers::pi;

template <int kRoughness_percent, int kGrain_percent>
void noise(Canvas& canvas, test::Random& random) {
  canvas.box(0, 0, 1, 1, 0, 0, random.uniform(90, 160));
  canvas.noise(random.bits(), random.uniform(30, 90), kRoughness_percent / 100.0, kGrain_percent / 100.0);
}

template <int kGrain_permille>
void blotches(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  canvas.box(0, 0, 1, 1, 0, 0, 128);
  canvas.noise(random.bits(), 60, 0.3, kGrain_permille / 1000.0);
  canvas.threshold(random.uniform(95, 130), tones.dark, tones.light);
}

void sand(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  canvas.box(0, 0, 1, 1, 0, 0, tones.light);
  canvas.noise(random.bits(), 15, 0.6, 0.4);
  for (int i = 0; i < 12000; ++i)
    canvas.disc(random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(0.002, 0.007),
                random.uniform(tones.dark, tones.light));
}

void pebbles(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  canvas.box(0, 0, 1, 1, 0, 0, tones.light);
  for (int i = 0; i < 900; ++i) {
    const double size = random.uniform(0.015, 0.06);
    const double x = random.uniform(-1, 1), y = random.uniform(-1, 1), angle_rad = random.uniform(0, kTurn_rad);
    const double level = random.uniform(tones.dark, tones.light);
    canvas.ellipse(x + 0.1 * size, y + 0.1 * size, 1.1 * size, 0.85 * size, angle_rad, tones.dark);
    canvas.ellipse(x, y, size, size * random.uniform(0.6, 1), angle_rad, level);
  }
}

void fur(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  canvas.box(0, 0, 1, 1, 0, 0, (tones.dark + tones.light) / 2);
  const double lie_rad = random.uniform(0, kTurn_rad);
  for (int i = 0; i < 7000; ++i) {
    const double x = random.uniform(-1, 1), y = random.uniform(-1, 1), a_rad = lie_rad + random.uniform(-0.4, 0.4);
    const double length = random.uniform(0.03, 0.09);
    canvas.bar(x, y, x + length * std::cos(a_rad), y + length * std::sin(a_rad), 0.005,
               random.uniform(tones.dark, tones.light));
  }
}

void spotted_fur(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  canvas.box(0, 0, 1, 1, 0, 0, tones.light);
  canvas.noise(random.bits(), 12, 0.7, 0.1);
  const double pitch = random.uniform(0.08, 0.16);
  for (double y = -1; y < 1; y += pitch)
    for (double x = -1; x < 1; x += pitch)
      canvas.ellipse(x + random.uniform(-0.4, 0.4) * pitch, y + random.uniform(-0.4, 0.4) * pitch,
                     pitch * random.uniform(0.15, 0.35), pitch * random.uniform(0.15, 0.3),
                     random.uniform(0, kTurn_rad), tones.dark * random.uniform(0.7, 1.3));
}

void bricks(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  canvas.box(0, 0, 1, 1, 0, 0, random.uniform(0, 1) < 0.5 ? tones.light : tones.dark);
  const double width = random.uniform(0.1, 0.25), height = width * random.uniform(0.3, 0.5), joint = 0.1 * height;
  int row = 0;
  for (double y = -1; y < 1; y += height, ++row)
    for (double x = -1 - (row % 2) * width / 2; x < 1; x += width)
      canvas.box(x + width / 2, y + height / 2, width / 2 - joint, height / 2 - joint, 0, 0.2 * height,
                 random.uniform(tones.dark, tones.light));
  canvas.noise(random.bits(), 12, 0.7, 0.1);
}

void tiles(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  const double side = random.uniform(0.08, 0.3), ornament = random.uniform(0.1, 0.35);
  canvas.box(0, 0, 1, 1, 0, 0, tones.dark);
  for (double y = -1 + side / 2; y < 1; y += side)
    for (double x = -1 + side / 2; x < 1; x += side) {
      canvas.box(x, y, 0.47 * side, 0.47 * side, 0, 0.03 * side, tones.light);
      canvas.disc(x, y, ornament * side, tones.dark);
      for (const double dx : {-0.5, 0.5})
        for (const double dy : {-0.5, 0.5})
          canvas.disc(x + dx * side, y + dy * side, 0.5 * ornament * side, tones.dark);
    }
}

void bubbles(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  canvas.box(0, 0, 1, 1, 0, 0, (tones.dark + tones.light) / 2);
  const double light_rad = random.uniform(0, kTurn_rad);
  for (int i = 0; i < 250; ++i)
    canvas.ball(random.uniform(-1, 1), random.uniform(-1, 1), 0.02 * std::exp(random.uniform(0, 1.8)), light_rad,
                tones.dark, tones.light);
}

// Lights out of focus: discs of one size and of any level, one over the other.
void bokeh(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  const bool dark = random.uniform(0, 1) < 0.5;
  canvas.box(0, 0, 1, 1, 0, 0, dark ? tones.light : tones.dark);
  const double radius = random.uniform(0.03, 0.1);
  for (int i = 0; i < 120; ++i)
    canvas.disc(random.uniform(-1, 1), random.uniform(-1, 1), radius * random.uniform(0.9, 1.1),
                random.uniform(tones.dark, tones.light));
}

}  // namespace

std::vector<NearMiss> texture_near_misses() {
  return {{"noise, white", noise<100, 1>},
          {"noise, pink", noise<70, 40>},
          {"noise, brown", noise<50, 80>},
          {"noise, smooth", noise<25, 15>},
          {"blotches, small", blotches<30>},
          {"blotches, large", blotches<120>},
          {"sand", sand},
          {"pebbles", pebbles},
          {"fur", fur},
          {"spotted fur", spotted_fur},
          {"brick walls", bricks},
          {"tiles with ornaments", tiles},
          {"bubbles", bubbles},
          {"lights out of focus", bokeh}};
}

}  // namespace ninedot::bench
