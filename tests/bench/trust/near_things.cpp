// Things with dots, holes and circles.
#include <cmath>
#include <numbers>

#include "tests/bench/trust/near_misses.h"

namespace ninedot::bench {
namespace {

constexpr double kTurn_rad = 2 * std::numbers::pi;

int random_below(test::Random& random, int end) {
  return static_cast<int>(random.bits() % static_cast<std::uint64_t>(end));
}

void wheel(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  const int spokes = 4 + random_below(random, 9);
  const double radius = random.uniform(0.3, 0.8), phase_rad = random.uniform(0, kTurn_rad);
  canvas.disc(0, 0, radius, tones.dark);
  canvas.disc(0, 0, 0.8 * radius, tones.light);
  for (int i = 0; i < spokes; ++i) {
    const double a_rad = phase_rad + kTurn_rad * i / spokes;
    canvas.bar(0, 0, 0.82 * radius * std::cos(a_rad), 0.82 * radius * std::sin(a_rad), 0.06 * radius, tones.dark);
  }
  canvas.disc(0, 0, 0.2 * radius, tones.dark);
}

// A rim with holes, a hub with bolts.
void rim(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  const double radius = random.uniform(0.3, 0.7);
  const int holes = 6 + random_below(random, 5);
  canvas.disc(0, 0, 1.3 * radius, tones.dark);
  canvas.disc(0, 0, radius, tones.light);
  Ring ring;
  ring.dots = holes, ring.radius = 0.72 * radius, ring.centre = random.uniform(0.15, 0.45);
  ring.dot = random.uniform(0.1, 0.22);
  paint_ring(canvas, 0, 0, ring, tones.dark);
  ring.dots = 4 + random_below(random, 3), ring.radius = 0.4 * radius, ring.centre = 0;
  paint_ring(canvas, 0, 0, ring, tones.dark);
}

void keyboard(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  const bool round = random.uniform(0, 1) < 0.3, dark_keys = random.uniform(0, 1) < 0.7;
  canvas.box(0, 0, 0.95, 0.4, 0, 0.05, dark_keys ? tones.light : tones.dark);
  const double key = dark_keys ? tones.dark : tones.light, print = dark_keys ? tones.light : tones.dark;
  for (int row = 0; row < 5; ++row)
    for (int column = 0; column < 13; ++column) {
      const double x = -0.86 + 0.135 * column + 0.03 * row, y = -0.28 + 0.135 * row;
      if (round) {
        canvas.disc(x, y, 0.052, key);
      } else {
        canvas.box(x, y, 0.057, 0.057, 0, 0.015, key);
      }
      canvas.bar(x - 0.01, y - 0.02, x - 0.01 + random.uniform(0, 0.02), y + 0.005, 0.008, print);
    }
}

// 0 to 6 spots of a die or of half a domino.
void spots(Canvas& canvas, double x, double y, double half, double turn_rad, int count, double level) {
  static constexpr std::array<std::array<double, 2>, 7> kPlaces{
      {{0, 0}, {-1, -1}, {1, 1}, {-1, 1}, {1, -1}, {-1, 0}, {1, 0}}};
  const double c = std::cos(turn_rad), s = std::sin(turn_rad);
  const std::size_t first = count % 2 == 1 ? 0 : 1, total = static_cast<std::size_t>(count / 2 * 2);
  for (std::size_t i = first; i <= total; ++i) {
    const double u = 0.55 * half * kPlaces[i][0], v = 0.55 * half * kPlaces[i][1];
    canvas.disc(x + c * u - s * v, y + s * u + c * v, 0.17 * half, level);
  }
}

void dice(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  for (int i = 0; i < 12; ++i) {
    const double x = random.uniform(-0.85, 0.85), y = random.uniform(-0.85, 0.85), half = random.uniform(0.08, 0.2);
    const double turn_rad = random.uniform(0, kTurn_rad);
    canvas.box(x, y, half, half, turn_rad, 0.25 * half, tones.light);
    spots(canvas, x, y, half, turn_rad, 1 + random_below(random, 6), tones.dark);
  }
}

void dominoes(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  const double half = random.uniform(0.08, 0.16);
  for (double y = -1 + half; y < 1; y += 2.2 * half)
    for (double x = -1 + 2 * half; x < 1; x += 4.3 * half) {
      canvas.box(x, y, 2 * half, half, 0, 0.1 * half, tones.light);
      canvas.bar(x, y - 0.7 * half, x, y + 0.7 * half, 0.05 * half, tones.dark);
      spots(canvas, x - half, y, half, 0, random_below(random, 7), tones.dark);
      spots(canvas, x + half, y, half, 0, random_below(random, 7), tones.dark);
    }
}

void text(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  canvas.box(0, 0, 0.95, 0.95, 0, 0, tones.light);
  const double size = random.uniform(0.02, 0.07);
  for (double y = -0.9; y < 0.9; y += 1.9 * size)
    for (double x = -0.9; x < 0.9; x += 0.8 * size) {
      if (random.uniform(0, 1) < 0.16) continue;
      for (int stroke = 0; stroke < 3; ++stroke) {
        const auto corner = [&] { return 0.25 * size * random_below(random, 3); };
        canvas.bar(x + corner(), y + 2 * corner(), x + corner(), y + 2 * corner(), 0.12 * size, tones.dark);
      }
      if (random.uniform(0, 1) < 0.2) canvas.disc(x + 0.3 * size, y - 0.35 * size, 0.1 * size, tones.dark);
    }
}

void square_code(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  canvas.box(0, 0, 0.7, 0.7, 0, 0, tones.light);
  const int cells = 21 + 4 * random_below(random, 5);
  const double cell = 1.2 / cells;
  const auto middle = [&](int i) { return -0.6 + (i + 0.5) * cell; };
  for (int j = 0; j < cells; ++j)
    for (int i = 0; i < cells; ++i)
      if (random.uniform(0, 1) < 0.5) canvas.box(middle(i), middle(j), cell / 2, cell / 2, 0, 0, tones.dark);
  for (const auto& [i, j] : {std::pair{3, 3}, {cells - 4, 3}, {3, cells - 4}}) {
    canvas.box(middle(i), middle(j), 4 * cell, 4 * cell, 0, 0, tones.light);
    canvas.box(middle(i), middle(j), 3.5 * cell, 3.5 * cell, 0, 0, tones.dark);
    canvas.box(middle(i), middle(j), 2.5 * cell, 2.5 * cell, 0, 0, tones.light);
    canvas.box(middle(i), middle(j), 1.5 * cell, 1.5 * cell, 0, 0, tones.dark);
  }
}

void checkerboard(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  const double half = random.uniform(0.02, 0.1);
  canvas.box(0, 0, 1, 1, 0, 0, tones.light);
  for (int j = 0; j * 2 * half < 2; ++j)
    for (int i = j % 2; i * 2 * half < 2; i += 2)
      canvas.box(-1 + (2 * i + 1) * half, -1 + (2 * j + 1) * half, half, half, 0, 0, tones.dark);
}

void traffic_lights(Canvas& canvas, test::Random& random) {
  for (int i = 0; i < 8; ++i) {
    const Tones tones = random_tones(random);
    const double x = random.uniform(-0.8, 0.8), y = random.uniform(-0.6, 0.6), radius = random.uniform(0.03, 0.12);
    canvas.box(x, y, 1.4 * radius, 4 * radius, 0, 0.3 * radius, random.uniform(0, 1) < 0.5 ? tones.dark : tones.light);
    for (int lamp = -1; lamp <= 1; ++lamp)
      canvas.disc(x, y + 2.5 * radius * lamp, radius, random.uniform(tones.dark, tones.light));
  }
}

void daisies(Canvas& canvas, test::Random& random) {
  for (int i = 0; i < 10; ++i) {
    const Tones tones = random_tones(random);
    const double x = random.uniform(-0.8, 0.8), y = random.uniform(-0.8, 0.8), radius = random.uniform(0.1, 0.3);
    const int petals = 5 + random_below(random, 9);
    canvas.disc(x, y, 1.4 * radius, tones.light);
    for (int k = 0; k < petals; ++k) {
      const double a_rad = kTurn_rad * k / petals;
      canvas.ellipse(x + radius * std::cos(a_rad), y + radius * std::sin(a_rad), 0.4 * radius, 1.8 * radius / petals,
                     a_rad, tones.dark);
    }
    canvas.disc(x, y, 0.32 * radius, tones.dark);
  }
}

void clock(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  const double radius = random.uniform(0.3, 0.8);
  canvas.disc(0, 0, 1.1 * radius, tones.dark);
  canvas.disc(0, 0, radius, tones.light);
  Ring ring;
  ring.dots = 12, ring.radius = 0.8 * radius, ring.centre = random.uniform(0.08, 0.3),
  ring.dot = random.uniform(0.05, 0.1);
  paint_ring(canvas, 0, 0, ring, tones.dark);
  for (const double length : {0.45, 0.7}) {
    const double a_rad = random.uniform(0, kTurn_rad);
    canvas.bar(0, 0, length * radius * std::cos(a_rad), length * radius * std::sin(a_rad), 0.05 * radius, tones.dark);
  }
}

void socket_strip(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  const double radius = random.uniform(0.1, 0.25);
  canvas.box(0, 0, 0.98, 1.4 * radius, 0, 0.1, tones.light);
  for (double x = -0.95 + radius; x < 0.95; x += 2.4 * radius) {
    canvas.disc(x, 0, radius, (tones.light + tones.dark) / 2);
    canvas.disc(x, 0, 0.9 * radius, tones.light);
    canvas.disc(x - 0.4 * radius, 0, 0.12 * radius, tones.dark);
    canvas.disc(x + 0.4 * radius, 0, 0.12 * radius, tones.dark);
  }
}

// Seven-segment dots, loudspeaker grilles: concentric rings of many small holes.
void loudspeaker(Canvas& canvas, test::Random& random) {
  const Tones tones = random_tones(random);
  canvas.box(0, 0, 1, 1, 0, 0, tones.light);
  const double pitch = random.uniform(0.06, 0.14);
  double hole = pitch * random.uniform(0.15, 0.35);
  const double centre = hole * random.uniform(1, 2);
  // The inner ring is not to be the landmark itself.
  const Ring own;
  const double least_other = 1.13 * own.dot * pitch;
  if (hole < least_other && centre > 0.875 * own.centre / own.dot * hole) hole = least_other;
  canvas.disc(0, 0, centre, tones.dark);
  for (int ring = 1; ring < 7; ++ring) {
    const int holes = 8 * ring;
    for (int i = 0; i < holes; ++i) {
      const double a_rad = kTurn_rad * i / holes;
      canvas.disc(ring * pitch * std::cos(a_rad), ring * pitch * std::sin(a_rad), hole, tones.dark);
    }
  }
}

}  // namespace

std::vector<NearMiss> thing_near_misses() {
  return {{"wheels with spokes", wheel},
          {"rims with holes and bolts", rim},
          {"keyboards", keyboard},
          {"dice", dice},
          {"dominoes", dominoes},
          {"text", text},
          {"square codes", square_code},
          {"checkerboards", checkerboard},
          {"traffic lights", traffic_lights},
          {"flowers", daisies},
          {"clocks", clock},
          {"sockets", socket_strip},
          {"loudspeakers", loudspeaker}};
}

}  // namespace ninedot::bench
