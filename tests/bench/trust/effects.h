#pragma once
/// What cameras and their software do to a picture.
#include <vector>

#include "tests/bench/trust/views.h"

namespace ninedot::bench {

/// A frame on its way through the camera.
struct Taken {
  const test::Exposure& exposure;  ///< what the effects of lens and sensor start from
  const test::Exposure& later;     ///< half a frame later; empty unless the effect asks for it
  const test::Sensor& sensor;
  const test::Picture& picture;  ///< what all others start from
  std::uint64_t seed;            ///< of this frame's noise
};

struct Effect {
  const char* name;
  /// \param random  the same in every frame of a track: for what does not change with time
  test::Picture (*apply)(const Taken& taken, test::Random& random);
  bool needs_later = false;  ///< its truth lies in the middle of both
};
std::vector<Effect> effects();

/// The same frames of one view through each of these effects.
/// \return  for each effect its shots
std::vector<std::vector<Shot>> shoot_through(const std::vector<Effect>& wanted, const MovingView& view, int frames,
                                             std::uint64_t seed);

// Filters of 8-bit pictures; edges are repeated.
test::Picture through_jpeg(const test::Picture& picture, int quality);
/// picture + amount (picture - blurred by sigma 1 px)
test::Picture sharpened(const test::Picture& picture, double amount);
test::Picture median_of_nine(const test::Picture& picture);
/// Tomasi & Manduchi, ICCV 1998: 5 x 5 pixels, the nearer in place and level, the more they count.
test::Picture bilateral(const test::Picture& picture, double sigma_px, double sigma_lsb);

}  // namespace ninedot::bench
