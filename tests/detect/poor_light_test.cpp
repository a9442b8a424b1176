#include <gtest/gtest.h>

#include <numbers>

#include "detect/detector.h"
#include "tests/support/renderer.h"

namespace ninedot {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

/// At a level of light at which ink differs from paper by 90 grey levels.
test::Scene poorly_lit(double distance_m, int turn, double noise_lsb) {
  test::Scene scene;
  scene.camera = test::look_at_landmark({.distance_m = distance_m,
                                         .tilt_rad = (15 + 5 * turn) * kDegree,
                                         .azimuth_rad = 1.3 * turn + distance_m,
                                         .off_axis_x_rad = 0.1 * (turn - 3)});
  scene.light.level = 0.25;
  set_noise(scene.sensor, noise_lsb);
  return scene;
}

bool is_found(const test::Scene& scene, int turn) {
  Detector detector(CameraModel{}, LandmarkGeometry{});
  return detector.find_landmarks(test::render(scene, static_cast<std::uint64_t>(turn)).view()).has_value();
}

TEST(PoorLight, HidesNoLandmarkWhereInkIsFourSigmaDarkerThanPaper) {
  int found = 0, count = 0;
  for (const double distance_m : {1.0, 2.0, 3.0, 4.0})
    for (int turn = 0; turn < 5; ++turn, ++count) found += is_found(poorly_lit(distance_m, turn, 24), turn);
  EXPECT_GE(found, count - 1);
}

TEST(PoorLight, LeavesThreeDotsBesideAShadowFound) {
  int found = 0, count = 0;
  for (const double distance_m : {2.0, 2.5, 3.0, 3.5})
    for (int turn = 0; turn < 8; ++turn, ++count) {
      test::Scene scene = poorly_lit(distance_m, turn, 20);
      scene.light.shadows.push_back(
          {.direction_rad = 0.7 * turn, .offset_m = 0.03, .width_m = 0.09, .penumbra_m = 0.01, .remaining = 0.12});
      found += is_found(scene, turn);
    }
  EXPECT_GE(found, 27) << "of " << count;
}

}  // namespace
}  // namespace ninedot
