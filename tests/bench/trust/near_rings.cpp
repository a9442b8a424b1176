// Rings of dots with something wrong: their number, their sizes, their places.
#include <cmath>
#include <numbers>

#include "tests/bench/trust/near_misses.h"

namespace ninedot::bench {
namespace {

constexpr double kTurn_rad = 2 * std::numbers::pi;

// On its paper, up to a tenth larger or smaller dots.
struct Drawn {
  Tones tones;
  Ring ring;
};
Drawn on_paper(Canvas& canvas, test::Random& random) {
  Drawn drawn{random_tones(random), {}};
  paint_paper(canvas, drawn.ring.radius, drawn.tones.light);
  const double size = random.uniform(0.9, 1.1);
  drawn.ring.dot *= size, drawn.ring.centre *= size;
  return drawn;
}

template <int kDots, bool kCentre>
void other_count(Canvas& canvas, test::Random& random) {
  auto [tones, ring] = on_paper(canvas, random);
  ring.dots = kDots;
  ring.phase_rad = random.uniform(0, kTurn_rad);
  if (!kCentre) ring.centre = 0;
  paint_ring(canvas, 0, 0, ring, tones.dark);
}

void narrow_ring(Canvas& canvas, test::Random& random) {
  auto [tones, ring] = on_paper(canvas, random);
  const double narrower = 0.72;
  ring.radius *= narrower, ring.dot /= narrower, ring.centre /= narrower;
  paint_ring(canvas, 0, 0, ring, tones.dark);
}

void wide_ring(Canvas& canvas, test::Random& random) {
  auto [tones, ring] = on_paper(canvas, random);
  const double wider = 1.4;
  paint_paper(canvas, ring.radius * wider, tones.light);
  ring.radius *= wider, ring.dot /= wider, ring.centre /= wider;
  paint_ring(canvas, 0, 0, ring, tones.dark);
}

// Each dot where the ring has it and a step away from it.
void displaced(Canvas& canvas, const Drawn& drawn, const std::array<std::array<double, 2>, 8>& steps) {
  const Ring& ring = drawn.ring;
  for (std::size_t i = 0; i < 8; ++i) {
    const double a_rad = kTurn_rad * static_cast<double>(i) / 8;
    canvas.disc(ring.radius * (std::sin(a_rad) + steps[i][0]), ring.radius * (std::cos(a_rad) + steps[i][1]),
                ring.dot * ring.radius, drawn.tones.dark);
  }
  canvas.disc(0, 0, ring.centre * ring.radius, drawn.tones.dark);
}

template <int kMoved>
void moved_dots(Canvas& canvas, test::Random& random) {
  const Drawn drawn = on_paper(canvas, random);
  std::array<std::array<double, 2>, 8> steps{};
  for (std::size_t k = 0; k < kMoved; ++k) {
    const double step = random.uniform(0.1, 0.4), a_rad = random.uniform(0, kTurn_rad);
    steps[(k * 3 + random.bits() % 3) % 8] = {step * std::cos(a_rad), step * std::sin(a_rad)};
  }
  displaced(canvas, drawn, steps);
}

void shaken(Canvas& canvas, test::Random& random) {
  const Drawn drawn = on_paper(canvas, random);
  std::array<std::array<double, 2>, 8> steps{};
  for (auto& step : steps) {
    const double a_rad = random.uniform(0, kTurn_rad), length = random.uniform(0.08, 0.16);
    step = {length * std::cos(a_rad), length * std::sin(a_rad)};
  }
  displaced(canvas, drawn, steps);
}

template <int kStep>
void alternate_missing(Canvas& canvas, test::Random& random) {
  const auto [tones, ring] = on_paper(canvas, random);
  paint_ring(canvas, 0, 0, ring, tones.dark);
  const int first = static_cast<int>(random.bits() % 2);
  for (int i = first; i < 8; i += kStep) {
    const double a_rad = kTurn_rad * i / 8;
    canvas.disc(ring.radius * std::sin(a_rad), ring.radius * std::cos(a_rad), 1.2 * ring.dot * ring.radius,
                tones.light);
  }
}

void small_centre(Canvas& canvas, test::Random& random) {
  auto [tones, ring] = on_paper(canvas, random);
  ring.centre = ring.dot;
  paint_ring(canvas, 0, 0, ring, tones.dark);
}

void large_centre(Canvas& canvas, test::Random& random) {
  auto [tones, ring] = on_paper(canvas, random);
  ring.centre = 3 * ring.dot;
  paint_ring(canvas, 0, 0, ring, tones.dark);
}

void ellipses(Canvas& canvas, test::Random& random) {
  const auto [tones, ring] = on_paper(canvas, random);
  const double narrow = random.uniform(0.35, 0.6), twist_rad = random.uniform(0, kTurn_rad);
  for (int i = 0; i < 8; ++i) {
    const double a_rad = kTurn_rad * i / 8, r = ring.dot * ring.radius;
    canvas.ellipse(ring.radius * std::sin(a_rad), ring.radius * std::cos(a_rad), r / std::sqrt(narrow),
                   r * std::sqrt(narrow), twist_rad - a_rad, tones.dark);
  }
  canvas.disc(0, 0, ring.centre * ring.radius, tones.dark);
}

void squares(Canvas& canvas, test::Random& random) {
  const auto [tones, ring] = on_paper(canvas, random);
  const double turn_rad = random.uniform(0, kTurn_rad), half = 0.9 * ring.dot * ring.radius;
  for (int i = 0; i < 8; ++i) {
    const double a_rad = kTurn_rad * i / 8;
    canvas.box(ring.radius * std::sin(a_rad), ring.radius * std::cos(a_rad), half, half, turn_rad - a_rad, 0,
               tones.dark);
  }
  const double middle = 0.9 * ring.centre * ring.radius;
  canvas.box(0, 0, middle, middle, turn_rad, 0, tones.dark);
}

void inverted(Canvas& canvas, test::Random& random) {
  const auto [tones, ring] = on_paper(canvas, random);
  paint_paper(canvas, ring.radius, tones.dark);
  paint_ring(canvas, 0, 0, ring, tones.light);
}

void hollow(Canvas& canvas, test::Random& random) {
  auto [tones, ring] = on_paper(canvas, random);
  paint_ring(canvas, 0, 0, ring, tones.dark);
  const double inside = random.uniform(0.5, 0.8);
  ring.dot *= inside, ring.centre *= inside;
  paint_ring(canvas, 0, 0, ring, tones.light);
}

void two_rings(Canvas& canvas, test::Random& random) {
  const auto [tones, ring] = on_paper(canvas, random);
  const double phase_rad = random.uniform(0, kTurn_rad);
  // Neither at the landmark's own radius.
  const double inner = random.uniform(0.6, 0.82), outer = random.uniform(1.18, 1.6);
  paint_paper(canvas, outer * ring.radius, tones.light);
  for (const double radius : {inner, outer}) {
    Ring one = ring;
    one.radius *= radius, one.dot /= radius, one.phase_rad = phase_rad;
    one.centre = radius < 1 ? ring.centre / radius : 0;
    paint_ring(canvas, 0, 0, one, tones.dark);
  }
}

void graded(Canvas& canvas, test::Random& random) {
  const auto [tones, ring] = on_paper(canvas, random);
  for (int i = 0; i < 8; ++i) {
    const double a_rad = kTurn_rad * i / 8;
    canvas.disc(ring.radius * std::sin(a_rad), ring.radius * std::cos(a_rad), ring.radius * ring.dot * (0.5 + i / 8.0),
                tones.dark);
  }
  canvas.disc(0, 0, ring.centre * ring.radius, tones.dark);
}

void off_centre(Canvas& canvas, test::Random& random) {
  auto [tones, ring] = on_paper(canvas, random);
  const double centre = ring.centre * ring.radius, a_rad = random.uniform(0, kTurn_rad),
               step = random.uniform(0.12, 0.3);
  ring.centre = 0;
  paint_ring(canvas, 0, 0, ring, tones.dark);
  canvas.disc(step * ring.radius * std::cos(a_rad), step * ring.radius * std::sin(a_rad), centre, tones.dark);
}

}  // namespace

std::vector<NearMiss> ring_near_misses() {
  return {{"ring of 5 and a centre", other_count<5, true>},
          {"ring of 6 and a centre", other_count<6, true>},
          {"ring of 7 and a centre", other_count<7, true>},
          {"ring of 9 and a centre", other_count<9, true>},
          {"ring of 10 and a centre", other_count<10, true>},
          {"ring of 11 and a centre", other_count<11, true>},
          {"ring of 12 and a centre", other_count<12, true>},
          {"ring of 5", other_count<5, false>},
          {"ring of 6", other_count<6, false>},
          {"ring of 7", other_count<7, false>},
          {"ring of 8", other_count<8, false>},
          {"ring of 9", other_count<9, false>},
          {"ring of 10", other_count<10, false>},
          {"ring of 11", other_count<11, false>},
          {"ring of 12", other_count<12, false>},
          {"ring of 0.72 R", narrow_ring},
          {"ring of 1.4 R", wide_ring},
          {"one dot moved by 10 to 40 % of R", moved_dots<1>, 0, false},
          {"two dots moved by 10 to 40 % of R", moved_dots<2>, 0, false},
          {"all dots moved by 8 to 16 % of R", shaken},
          {"every second dot missing", alternate_missing<2>},
          {"every third dot missing", alternate_missing<3>},
          {"centre as small as the ring's dots", small_centre},
          {"centre three times a ring's dot", large_centre},
          {"centre aside by 12 to 30 % of R", off_centre},
          {"ellipses for dots", ellipses},
          {"squares for dots", squares},
          {"hollow dots", hollow},
          {"dots of growing size", graded},
          {"white on black", inverted},
          {"two concentric rings", two_rings}};
}

}  // namespace ninedot::bench
