#pragma once
/// Things that look like the landmark and are none, each painted anew for every seed.
#include <vector>

#include "tests/bench/trust/canvas.h"
#include "tests/bench/trust/strip.h"

namespace ninedot::bench {

/// One kind of them.
struct NearMiss {
  const char* name;
  void (*paint)(Canvas& canvas, test::Random& random);
  double fold = 0;      ///< see Look
  bool repeats = true;  ///< copies beside it; not where a copy cut by the picture's border would hide what is wrong
};

std::vector<NearMiss> ring_near_misses();     ///< rings of dots with something wrong
std::vector<NearMiss> dot_near_misses();      ///< dots without a ring: strewn, in rows, in grids
std::vector<NearMiss> thing_near_misses();    ///< things with dots and circles
std::vector<NearMiss> texture_near_misses();  ///< surfaces
std::vector<NearMiss> near_misses();          ///< all of them

/// Ink and paper of one picture.
struct Tones {
  double dark, light;
};
Tones random_tones(test::Random& random);

/// The ring that near misses are made of. Defaults: the landmark's proportions.
struct Ring {
  int dots = 8;
  double radius = 0.25;            ///< on the canvas
  double dot = 0.0127 / 0.080;     ///< radius of a dot, in radii of the ring
  double centre = 0.0254 / 0.080;  ///< of the one in the middle; 0: none
  double phase_rad = 0;
};
void paint_ring(Canvas& canvas, double x, double y, const Ring& ring, double level);
/// The sheet that the landmark is printed on, around the canvas's middle.
void paint_paper(Canvas& canvas, double ring_radius, double level);

Shot draw_near_miss(const NearMiss& kind, std::uint64_t seed);

}  // namespace ninedot::bench
