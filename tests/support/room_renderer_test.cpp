// The renderer of rooms, held against the renderer of one wall, and its camera's motion against what can be written
// down.
#include "tests/support/room_renderer.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string_view>

#include "tests/support/renderer_optics.h"

namespace ninedot::test {
namespace {

// Enough to see an edge, and quick.
const Lens kSmall{.width_px = 120, .height_px = 80, .fx_px = 300, .fy_px = 300, .cx_px = 59.5, .cy_px = 39.5};

// One landmark on the wall whose frame is the world's own.
Room wall_room() {
  Room room;
  room.low_m = {-30, 0, -30}, room.high_m = {30, 30, 30};
  room.wall = {0.35, 0, 0.12, 1};
  room.landmarks = {{RoomSide::kLowY, 0, 0, inks_of_code("KRGBKKRB"), {0.9, 0.9, 0.9}}};
  room.light = {1.1, 1, 0.8};
  return room;
}

TEST(RoomRenderer, IsTheRendererOfOneWallWhereNothingMoves) {
  ColourScene scene;
  scene.scene.camera = look_at_landmark({1.1, 0.5, 0.4, 0.1, 0.05, 0.02});
  scene.scene.wall.contrast = 0;
  scene.scene.lens.k = {-0.12, 0.05, 0.0008, -0.0005};
  set_noise(scene.scene.sensor, 1.5);
  const auto inks = inks_of_code("KRGBKKRB");
  scene.discs.assign(inks.begin(), inks.end());
  scene.light = wall_room().light;
  const Sensor& sensor = scene.scene.sensor;
  const RoomRenderer renderer(wall_room(), scene.scene.lens, sensor);
  const auto exposure = renderer.expose([&](double) { return scene.scene.camera; }, {.row_time_s = 1e-4});
  const ColourPicture room = read_out(exposure, sensor, ChromaLayout::k420, 7);
  const ColourPicture wall = render_colour(scene, ChromaLayout::k420, 7);
  EXPECT_TRUE(room.luma.pixels == wall.luma.pixels);
  EXPECT_TRUE(room.chroma_bytes == wall.chroma_bytes);
}

// From the same place before each of them the picture is that of one wall: upright, not mirrored, where it says, and
// the landmark of this wall.
TEST(RoomRenderer, HangsLandmarksOnEachWallAlike) {
  const std::array<std::string_view, 4> codes{"KRGBKKRB", "RRGKBGKB", "KKGRRBGB", "RKBGGKRB"};
  Room room;
  room.wall.contrast = 0;
  for (std::size_t side = 0; side < codes.size(); ++side)
    room.landmarks.push_back({static_cast<RoomSide>(side), 0.7, 1.4, inks_of_code(codes[side])});
  const RoomRenderer renderer(room, kSmall, Sensor{});
  Scene scene;
  scene.lens = kSmall, scene.camera = look_at_landmark({0.8, 0.4, 0.4, 0.3, 0, 0});
  scene.wall.contrast = 0;
  scene.sheets[0].reflectance = 0.84;
  for (const HungLandmark& landmark : room.landmarks) {
    const Eigen::Matrix3d axes = axes_of(landmark.side);
    const Eigen::Quaterniond q(axes * rotation_of(scene.camera));
    const Eigen::Vector3d p_m = place_of(room, landmark) + axes * Eigen::Vector3d(scene.camera.position_m.data());
    const CameraPose camera{{p_m.x(), p_m.y(), p_m.z()}, {q.w(), q.x(), q.y(), q.z()}};
    const Exposure red = renderer.expose([&](double) { return camera; }, {})[0];
    for (std::size_t i = 0; i < landmark.discs.size(); ++i)
      scene.sheets[0].discs[i].reflectance = landmark.discs[i].red;
    const Exposure expected = expose(scene);
    for (std::size_t i = 0; i < red.light.size(); ++i)
      ASSERT_NEAR(red.light[i], expected.light[i], 1e-9) << static_cast<int>(landmark.side);
  }
}

// A wall that is dark to the left of X = 0 (the viewer's right) and bright beyond, as seen from straight ahead.
struct EdgeView {
  Room room;
  static constexpr double kDistance_m = 2;
  static constexpr double kDark = 0.2, kBright = 0.8;

  EdgeView() {
    room.low_m = {-20, 0, -20}, room.high_m = {20, 20, 20};
    room.wall = {kDark, 0, 0.1, 1};
    room.lamp.ambient = 1;
    room.posters = {{RoomSide::kLowY, 5, 0, 10, 30, {kBright, kBright, kBright}}};
  }

  /// Green light; the edge goes through the middle of the picture at the time 0 and to the right by so much.
  Exposure expose(double speed_px_s, const Shutter& shutter) const {
    const auto way = [&](double after_s) {
      // Ahead is -Y of the world, right is -X: where the camera goes left, the edge goes right.
      return CameraPose{{speed_px_s / kSmall.fx_px * kDistance_m * after_s, kDistance_m, 0}, {0, 0, kHalf, -kHalf}};
    };
    return RoomRenderer(room, kSmall, Sensor{}).expose(way, shutter)[1];
  }
  static constexpr double kHalf = std::numbers::sqrt2 / 2;
};

/// Second antiderivative of the Gaussian's distribution.
double ramp(double x, double sigma) {
  const double density = std::exp(-x * x / (2 * sigma * sigma)) / std::sqrt(2 * std::numbers::pi);
  return ((x * x + sigma * sigma) * 0.5 * std::erfc(-x / sigma / std::numbers::sqrt2) + sigma * x * density) / 2;
}

/// A step, smoothed by a Gaussian and two boxes, at x px beyond it.
double smoothed_step(double x_px, double sigma_px, double box_px, double other_px) {
  const double sum_px = (box_px + other_px) / 2, difference_px = (box_px - other_px) / 2;
  return (ramp(x_px + sum_px, sigma_px) - ramp(x_px + difference_px, sigma_px) - ramp(x_px - difference_px, sigma_px) +
          ramp(x_px - sum_px, sigma_px)) /
         (box_px * other_px);
}

TEST(RoomRenderer, BlursAnEdgeByTheWayThatItGoesWhileExposed) {
  const EdgeView view;
  for (const double way_px : {0.8, 3.0, 6.4}) {
    const Exposure seen = view.expose(way_px / 0.004, {.exposure_s = 0.004});
    for (int x = 0; x < kSmall.width_px; ++x) {
      const double bright = 1 - smoothed_step(x - kSmall.cx_px, Sensor{}.point_spread_px, 1, way_px);
      const double expected = EdgeView::kDark + (EdgeView::kBright - EdgeView::kDark) * bright;
      EXPECT_NEAR(seen.at(x, 40), expected, 0.002) << way_px << " px, at " << x;
    }
  }
}

TEST(RoomRenderer, SlantsAnEdgeByTheWayThatItGoesFromRowToRow) {
  const EdgeView view;
  const double slant = 0.09, row_time_s = 1e-4;  // px per row: a fast turn of a slow shutter
  const Exposure seen = view.expose(slant / row_time_s, {.row_time_s = row_time_s});
  for (int y = 0; y < kSmall.height_px; ++y) {
    double bright = 0;
    for (int x = 0; x < kSmall.width_px; ++x)
      bright += (seen.at(x, y) - EdgeView::kDark) / (EdgeView::kBright - EdgeView::kDark);
    const double expected_px = kSmall.cx_px + slant * (y - (kSmall.height_px - 1) / 2.0);
    EXPECT_NEAR(bright - 0.5, expected_px, 0.002) << "row " << y;
  }
}

// Between rows the camera moves on: even where an edge moves by half a pixel from row to row it has no steps.
TEST(RoomRenderer, SlantsAnEdgeWithoutSteps) {
  const EdgeView view;
  const double slant = 0.5, row_time_s = 1e-4, sigma_px = Sensor{}.point_spread_px * std::hypot(1, slant);
  const Exposure seen = view.expose(slant / row_time_s, {.row_time_s = row_time_s});
  const double edge_px = kSmall.cx_px + slant * (40 - (kSmall.height_px - 1) / 2.0);
  for (int x = 0; x < kSmall.width_px; ++x) {
    const double bright = 1 - smoothed_step(x - edge_px, sigma_px, 1, slant);
    const double expected = EdgeView::kDark + (EdgeView::kBright - EdgeView::kDark) * bright;
    EXPECT_NEAR(seen.at(x, 40), expected, 0.002) << x;
  }
}

// All parts of the exposure show the same: their number must not count.
TEST(RoomRenderer, SeesAtRestWhatAShortExposureSees) {
  const EdgeView view;
  const Exposure once = view.expose(0, {}), often = view.expose(0, {.exposure_s = 0.01});
  for (std::size_t i = 0; i < once.light.size(); ++i) ASSERT_NEAR(once.light[i], often.light[i], 2e-3);
}

TEST(RoomRenderer, LampLightsByDistanceAndIncidence) {
  Room room;
  room.wall = {0.5, 0, 0.1, 1};
  room.lamp = {{2.0, 0.5, 1.2}, 0.3, 3.2, 1.5};
  const CameraPose ahead{{1, -0.5, 1.4}, {0.5, -0.5, 0.5, -0.5}};  // +X, at (4, -0.5, 1.4)
  Lens odd = kSmall;
  odd.cx_px = 60, odd.cy_px = 40;
  const Exposure seen = RoomRenderer(room, odd, Sensor{}).expose([&](double) { return ahead; }, {})[0];
  const double r2_m2 = 2 * 2 + 1 + 0.2 * 0.2;
  EXPECT_NEAR(seen.at(60, 40), 0.5 * (0.3 + 3.2 * (2 / std::sqrt(r2_m2)) / (r2_m2 + 1.5)), 1e-4);
}

}  // namespace
}  // namespace ninedot::test
