#include "tests/bench/trust/near_misses.h"

#include <cmath>
#include <numbers>

namespace ninedot::bench {

Tones random_tones(test::Random& random) {
  const double dark = random.uniform(10, 70);
  return {dark, random.uniform(dark + 90, 250)};
}

void paint_ring(Canvas& canvas, double x, double y, const Ring& ring, double level) {
  for (int i = 0; i < ring.dots; ++i) {
    const double a_rad = ring.phase_rad + 2 * std::numbers::pi * i / ring.dots;
    canvas.disc(x + ring.radius * std::sin(a_rad), y + ring.radius * std::cos(a_rad), ring.dot * ring.radius, level);
  }
  if (ring.centre > 0) canvas.disc(x, y, ring.centre * ring.radius, level);
}

void paint_paper(Canvas& canvas, double ring_radius, double level) {
  const double half = 0.105 / 0.080 * ring_radius;
  canvas.box(0, 0, half, half, 0, 0, level);
}

std::vector<NearMiss> near_misses() {
  std::vector<NearMiss> all;
  for (const auto& list : {ring_near_misses(), dot_near_misses(), thing_near_misses(), texture_near_misses()})
    all.insert(all.end(), list.begin(), list.end());
  return all;
}

Shot draw_near_miss(const NearMiss& kind, std::uint64_t seed) {
  test::Random random(seed);
  Canvas canvas(random.uniform(60, 200));
  kind.paint(canvas, random);
  Look look = random_look(random);
  look.fold = kind.fold;
  look.repeat = look.repeat && kind.repeats;
  Shot shot;
  shot.picture = look_at(canvas, look, seed);
  return shot;
}

}  // namespace ninedot::bench
