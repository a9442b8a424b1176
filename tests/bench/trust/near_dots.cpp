// Dots without a ring: strewn, in rows, in grids.
#include <cmath>
#include <numbers>

#include "tests/bench/trust/near_misses.h"

namespace ninedot::bench {
namespace {

constexpr double kTurn_rad = 2 * std::numbers::pi;

template <int kLeast, int kMost, bool kMixed>
void strewn(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  canvas.box(0, 0, 1, 1, 0, 0, tones.light);
  const double count = std::exp(random.uniform(std::log(kLeast), std::log(kMost)));
  const double typical = 0.55 / std::sqrt(count);  // they cover a quarter of the canvas
  for (int i = 0; i < count; ++i) {
    const double x = random.uniform(-1, 1), y = random.uniform(-1, 1);
    const double radius = kMixed ? typical * std::exp(random.uniform(-1.2, 0.5)) : 0.8 * typical;
    canvas.disc(x, y, radius, kMixed ? tones.dark * random.uniform(0.6, 1.4) : tones.dark);
  }
}

enum class Lattice : std::uint8_t { kSquare, kHexagonal };

// dot(x, y): paints one. Turned as a whole.
template <typename Dot>
void lattice(Lattice kind, double pitch, double turn_rad, const Dot& dot) {
  const double row_pitch = kind == Lattice::kSquare ? pitch : pitch * std::sqrt(3.0) / 2;
  const int reach = static_cast<int>(1.5 / row_pitch) + 1;
  const double c = std::cos(turn_rad), s = std::sin(turn_rad);
  for (int row = -reach; row <= reach; ++row)
    for (int column = -reach; column <= reach; ++column) {
      const double shift = kind == Lattice::kHexagonal && row % 2 != 0 ? 0.5 : 0;
      const double u = (column + shift) * pitch, v = row * row_pitch;
      const double x = c * u - s * v, y = s * u + c * v;
      if (std::abs(x) < 1 && std::abs(y) < 1) dot(x, y);
    }
}

void polka(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  canvas.box(0, 0, 1, 1, 0, 0, tones.light);
  const double pitch = random.uniform(0.08, 0.3), radius = pitch * random.uniform(0.15, 0.35);
  const Lattice kind = random.uniform(0, 1) < 0.5 ? Lattice::kSquare : Lattice::kHexagonal;
  lattice(kind, pitch, random.uniform(0, kTurn_rad),
          [&](double x, double y) { canvas.disc(x, y, radius, tones.dark); });
}

// Two sizes by turns, as printed cloth has them.
void polka_of_two_sizes(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  canvas.box(0, 0, 1, 1, 0, 0, tones.light);
  const double pitch = random.uniform(0.1, 0.3), turn_rad = random.uniform(0, kTurn_rad);
  const double large = pitch * random.uniform(0.22, 0.35), small = large * random.uniform(0.4, 0.6);
  int count = 0;
  lattice(Lattice::kSquare, pitch, turn_rad,
          [&](double x, double y) { canvas.disc(x, y, ++count % 2 == 0 ? large : small, tones.dark); });
}

void halftone(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  canvas.box(0, 0, 1, 1, 0, 0, tones.light);
  const double pitch = random.uniform(0.025, 0.08), phase = random.uniform(0, kTurn_rad), wave = random.uniform(3, 9);
  lattice(Lattice::kSquare, pitch, random.uniform(0, kTurn_rad), [&](double x, double y) {
    const double ink = 0.5 + 0.45 * std::sin(wave * x + phase) * std::cos(wave * y - phase);
    canvas.disc(x, y, pitch * 0.5 * std::sqrt(ink), tones.dark);
  });
}

void symmetric_grid(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  const int columns = 4 + static_cast<int>(random.bits() % 7), rows = 3 + static_cast<int>(random.bits() % 6);
  const double pitch = 0.15, radius = pitch * random.uniform(0.15, 0.4);
  canvas.box(0, 0, pitch * columns / 2 + 0.1, pitch * rows / 2 + 0.1, 0, 0, tones.light);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      canvas.disc(pitch * (column - (columns - 1) / 2.0), pitch * (row - (rows - 1) / 2.0), radius, tones.dark);
}

void asymmetric_grid(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  const int columns = 3 + static_cast<int>(random.bits() % 3), rows = 7 + static_cast<int>(random.bits() % 5);
  const double pitch = 0.13, radius = pitch * random.uniform(0.2, 0.45);
  canvas.box(0, 0, pitch * columns + 0.1, pitch * rows / 2 + 0.1, 0, 0, tones.light);
  for (int row = 0; row < rows; ++row)
    for (int column = 0; column < columns; ++column)
      canvas.disc(pitch * (2 * column + row % 2 - columns + 0.5), pitch * (row - (rows - 1) / 2.0), radius, tones.dark);
}

// A hole shows the dark behind it and a lit edge.
void pegboard(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  canvas.box(0, 0, 1, 1, 0, 0, tones.light);
  const double pitch = random.uniform(0.08, 0.16), radius = pitch * random.uniform(0.1, 0.2);
  const double light_rad = random.uniform(0, kTurn_rad);
  lattice(Lattice::kSquare, pitch, 0, [&](double x, double y) {
    canvas.disc(x + 0.2 * radius * std::cos(light_rad), y + 0.2 * radius * std::sin(light_rad), radius, 250);
    canvas.disc(x, y, radius, tones.dark);
  });
}

void perforated(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  canvas.box(0, 0, 1, 1, 0, 0, tones.light);
  canvas.noise(random.bits(), 8, 0.5, 0.7);
  const double pitch = random.uniform(0.04, 0.12), radius = pitch * random.uniform(0.3, 0.42);
  lattice(Lattice::kHexagonal, pitch, random.uniform(0, kTurn_rad),
          [&](double x, double y) { canvas.disc(x, y, radius, tones.dark); });
}

void rivets(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  canvas.box(0, 0, 1, 1, 0, 0, (tones.dark + tones.light) / 2);
  canvas.noise(random.bits(), 10, 0.5, 0.5);
  const double radius = random.uniform(0.012, 0.03), light_rad = random.uniform(0, kTurn_rad);
  const auto rivet = [&](double x, double y) {
    canvas.disc(x - 0.4 * radius * std::cos(light_rad), y - 0.4 * radius * std::sin(light_rad), 1.1 * radius,
                tones.dark);
    canvas.ball(x, y, radius, light_rad, tones.dark + 30, tones.light);
  };
  const double rows = random.uniform(0.15, 0.5);
  for (double y = -1; y < 1; y += rows)
    for (double x = -1; x < 1; x += 5 * radius) rivet(x, y), rivet(y, x);
}

// Where dots of a ring meet: arcs and rosettes of many radii.
void arcs(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  canvas.box(0, 0, 1, 1, 0, 0, tones.light);
  for (int arc = 0; arc < 14; ++arc) {
    const double x = random.uniform(-1, 1), y = random.uniform(-1, 1), radius = random.uniform(0.08, 0.5);
    const double from_rad = random.uniform(0, kTurn_rad), step_rad = random.uniform(0.3, 1.1);
    const double dot = radius * random.uniform(0.1, 0.2);
    for (int i = 0; i < 4; ++i)
      canvas.disc(x + radius * std::cos(from_rad + i * step_rad), y + radius * std::sin(from_rad + i * step_rad), dot,
                  tones.dark);
    if (arc % 2 == 0) canvas.disc(x, y, 2 * dot, tones.dark);
  }
}

}  // namespace

std::vector<NearMiss> dot_near_misses() {
  return {{"5 to 60 random dots of one size", strewn<5, 60, false>},
          {"60 to 1000 random dots of one size", strewn<60, 1000, false>},
          {"1000 to 10000 random dots of one size", strewn<1000, 10000, false>},
          {"5 to 60 random dots", strewn<5, 60, true>},
          {"60 to 1000 random dots", strewn<60, 1000, true>},
          {"1000 to 10000 random dots", strewn<1000, 10000, true>},
          {"arcs of dots", arcs},
          {"polka dots", polka},
          {"polka dots on folded cloth", polka, 0.03},
          {"polka dots of two sizes, on folded cloth", polka_of_two_sizes, 0.02},
          {"halftone", halftone},
          {"calibration grid, symmetric", symmetric_grid},
          {"calibration grid, asymmetric", asymmetric_grid},
          {"pegboard", pegboard},
          {"perforated sheet", perforated},
          {"rivets", rivets}};
}

}  // namespace ninedot::bench
