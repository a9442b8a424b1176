#pragma once
/// Rendered views of the landmark with exact truth.
#include <vector>

#include "tests/bench/trust/strip.h"
#include "tests/support/random.h"

namespace ninedot::bench {

/// A scene whose camera moves.
struct MovingView {
  test::Viewpoint at;         ///< of the first frame
  test::Viewpoint per_frame;  ///< what is added to it from one frame to the next; all that is not said is zero
  test::Scene scene;
  bool has_bound = true;  ///< the Cramer-Rao bound's model holds: even light, a flat sheet, no motion
  double smear_px = 0;    ///< length of the motion during the exposure
  double smear_rad = 0;   ///< its direction, 0 = along the rows
};

struct ViewKind {
  const char* name;
  void (*set)(MovingView& view, test::Random& random);  ///< changes what `usual_view` has drawn
};
std::vector<ViewKind> view_kinds();

/// Landmark at 1 to 3 m, tilted by 10 to 45 degrees, camera rolled by up to 10, usual noise, even light, slow motion.
MovingView usual_view(test::Random& random);

/// The scene as it is seen after so many frames, a fraction for what lies between two.
test::Scene scene_at(const MovingView& view, double frame);

/// Smears light along a straight line.
test::Exposure smeared(const test::Exposure& exposure, double length_px, double direction_rad);

/// The first frames of a view, 30 ms apart; the first one with its bound.
std::vector<Shot> shoot(const MovingView& view, int frames, std::uint64_t seed);

inline constexpr int kTrackFrames = 10;
inline constexpr std::chrono::milliseconds kFrameTime{30};

}  // namespace ninedot::bench
