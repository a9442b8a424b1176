// What hangs on the wall beside a distant sheet, and is seen in the blur of its dots.
#include <gtest/gtest.h>

#include <cmath>

#include "pose/outline_refiner.h"
#include "pose/pose_of_outlines.h"
#include "tests/pose/first_fit.h"

namespace ninedot {
namespace {

const CameraModel kCamera{};
const LandmarkGeometry kLandmark{};
const RayTable kRays{kCamera};

/// A sheet of which the upper half hangs beside something dark, to the viewer's left.
test::Scene beside_a_poster(double azimuth_rad, double reflectance) {
  test::Scene scene =
      test::scene_of(test::nine_dot_sheet(), {.distance_m = 5.2, .tilt_rad = 0.5, .azimuth_rad = azimuth_rad});
  scene.sensor.point_spread_px = 0.8;
  test::Sheet poster;
  poster.x_m = 0.205, poster.z_m = 0.15, poster.width_m = 0.2, poster.height_m = 0.3, poster.reflectance = reflectance;
  scene.sheets.push_back(poster);
  return scene;
}

struct Errors {
  Eigen::Vector2d mean_px = Eigen::Vector2d::Zero();
  double mean_information = 0;
};

/// Of the dot on the viewer's left, over some pictures.
Errors errors_beside(double reflectance, bool regards_walls) {
  constexpr std::size_t kLeftDot = 2;
  constexpr int kPictures = 12;
  Errors errors;
  OutlineRefiner refiner(kCamera, kLandmark, kRays, regards_walls);
  for (int i = 0; i < kPictures; ++i) {
    const test::Scene scene = beside_a_poster(0.5 * i, reflectance);
    const test::Picture picture = test::render(scene, static_cast<std::uint64_t>(i));
    const auto& [position_m, q] = scene.camera;
    OutlineState start;
    start.T_camera_landmark = Transform<frame::Landmark, frame::Camera>{
        Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix(),
        {position_m[0], position_m[1],
         position_m[2]}}.inverse();
    int pixels = 100'000;
    refiner.refine(picture.view(), start, OutlineRefiner::Start::kClose, 0, pixels);
    const DotSighting dot = candidate_of(refiner, kCamera, kLandmark).dots[kLeftDot];
    const Eigen::Vector2d C = kLandmark.centre_m(kLeftDot);
    const Eigen::Vector2d ray = (start.T_camera_landmark * Eigen::Vector3d(C.x(), 0, C.y())).hnormalized();
    errors.mean_px += kCamera.fx_px * (dot.ray - ray) / kPictures;
    errors.mean_information += dot.information.trace() / kPictures;
  }
  return errors;
}

TEST(Wall, ThatChangesAlongASideMovesNoDotBesideItWhereItIsRegarded) {
  const Errors taken_for_even = errors_beside(0.04, false), regarded = errors_beside(0.04, true);
  EXPECT_GT(std::abs(taken_for_even.mean_px.y()), 0.04);
  EXPECT_LT(std::abs(regarded.mean_px.y()), 0.02);
}

/// Of a wall that is even it costs a little of what the dot says.
TEST(Wall, ThatIsEvenIsRegardedAtASmallPrice) {
  const test::Scene usual;
  const Errors taken_for_even = errors_beside(usual.wall.reflectance, false),
               regarded = errors_beside(usual.wall.reflectance, true);
  EXPECT_LT(regarded.mean_information, 0.999 * taken_for_even.mean_information);
  EXPECT_GT(regarded.mean_information, 0.95 * taken_for_even.mean_information);
}

}  // namespace
}  // namespace ninedot
