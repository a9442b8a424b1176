#include "tests/bench/room_bound.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstddef>

namespace ninedot::bench {
namespace {

// Two landmarks on two walls, paper 200 and ink 50 grey levels, noise 2, blur 0.6 px in all.
struct PlainRoom {
  test::Room room;
  test::Lens lens;
  test::Sensor sensor;
  test::CameraPose camera{{1.5, 0.2, 1.3}, {0.66006258, -0.59911333, 0.33896201, -0.30080785}};

  PlainRoom() {
    const test::LinearRgb paper{200 / 255.0, 200 / 255.0, 200 / 255.0}, ink{50 / 255.0, 50 / 255.0, 50 / 255.0};
    room.lamp.ambient = 1;
    room.landmarks = {{test::RoomSide::kHighX, 1, 1.4, {}, paper}, {test::RoomSide::kHighY, 3.5, 1.6, {}, paper}};
    for (test::HungLandmark& landmark : room.landmarks) landmark.discs.fill(ink);
    sensor.tone = test::ToneCurve::kLinear;
    sensor.point_spread_px = std::sqrt(0.36 - 1.0 / 12);
    sensor.noise_b = (4 - 1.0 / 12) / (255 * 255);
  }
  double bound_m(std::span<const std::size_t> shown) const {
    return room_bound_m(room, shown, lens, sensor, camera).value_or(0);
  }
};

constexpr std::array<std::size_t, 2> kBoth{0, 1};

// Computed by a separate program, in another language, with numerical derivatives.
TEST(RoomBound, AgreesWithIndependentlyComputedValues) {
  const PlainRoom unit;
  EXPECT_NEAR(1000 * unit.bound_m(std::array<std::size_t, 1>{0}) / 1.9839, 1, 0.03);
  EXPECT_NEAR(1000 * unit.bound_m(std::array<std::size_t, 1>{1}) / 2.1066, 1, 0.03);
  EXPECT_NEAR(1000 * unit.bound_m(kBoth) / 0.5549, 1, 0.03);
}

TEST(RoomBound, DoesNotExistWhereNoLandmarkIsShown) {
  const PlainRoom unit;
  EXPECT_FALSE(room_bound_m(unit.room, {}, unit.lens, unit.sensor, unit.camera));
}

// Red is 0.3 of luma: of discs that are as bright as paper there, the rest of the contrast is left.
TEST(RoomBound, CountsTheContrastThatEachInkHas) {
  PlainRoom unit;
  const double black_m = unit.bound_m(kBoth);
  for (test::HungLandmark& landmark : unit.room.landmarks)
    for (test::LinearRgb& disc : landmark.discs) disc.red = landmark.paper.red;
  EXPECT_NEAR(unit.bound_m(kBoth) / black_m, 1 / (1 - 0.299), 1e-6);
  for (test::HungLandmark& landmark : unit.room.landmarks)
    for (std::size_t i = 0; i < 4; ++i) landmark.discs[i] = {50 / 255.0, 50 / 255.0, 50 / 255.0};
  const double mixed_m = unit.bound_m(kBoth);
  EXPECT_GT(mixed_m, 1.02 * black_m);
  EXPECT_LT(mixed_m, 0.98 * black_m / (1 - 0.299));
}

TEST(RoomBound, GrowsAsTheLampFades) {
  PlainRoom unit;
  const double bright_m = unit.bound_m(kBoth);
  unit.room.lamp.ambient = 0.5;
  EXPECT_NEAR(unit.bound_m(kBoth) / bright_m, 2, 1e-6);
}

}  // namespace
}  // namespace ninedot::bench
