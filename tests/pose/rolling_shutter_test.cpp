// Rows that are exposed one after the other: the pose is that of the middle one, whatever rows the landmark is in.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "detect/detector.h"
#include "pose/full_solver.h"
#include "pose/outline_pixels.h"
#include "tests/support/renderer.h"

namespace ninedot {
namespace {

constexpr double kRowTime_s = 33e-6;

CameraModel small_camera() {
  CameraModel camera;
  camera.width_px = 320, camera.height_px = 240;
  camera.fx_px = camera.fy_px = 360;
  camera.cx_px = 159.5, camera.cy_px = 119.5;
  return camera;
}

SheetMotion motion_of(const Eigen::Vector3d& rotation_rad_s, const Eigen::Vector3d& translation_m_s) {
  return {rotation_rad_s, translation_m_s, kRowTime_s, 119.5};
}

/// A ray is where its pixel's spot of the sheet would have been seen from, had the sheet stood still.
TEST(RollingShutter, RaysAreThoseOfTheMiddleRow) {
  const CameraModel camera = small_camera();
  const RayTable rays(camera);
  const CameraFromLandmark T{exp_so3({1.2, 0.3, 0.1}), {0.1, 0.15, 1.1}};
  const SheetMotion motion = motion_of({0.4, -0.3, 0.5}, {0.9, -0.4, 0.3});
  OutlinePixels pixels(12000);
  collect_outline_pixels(ImageView{std::vector<std::uint8_t>(320 * 240, 128).data(), 320, 240, 320}, camera, rays, {},
                         T, 2, 1, {}, motion, pixels);
  ASSERT_GT(pixels.count, 500U);
  for (std::size_t i = 0; i < pixels.count; ++i) {
    const Eigen::Vector3d seen = camera.normalised_from_pixel({pixels.x_px[i], pixels.y_px[i]}).value().homogeneous();
    // Where it meets the sheet at its row's time, and from where that is seen at the middle row's.
    const CameraFromLandmark then = motion.after(T, motion.since_s(pixels.y_px[i]));
    const Eigen::Vector3d n = then.rotation.col(1);
    const Eigen::Vector3d on_sheet_m = then.inverse() * (seen * (n.dot(then.translation_m) / n.dot(seen)));
    const Eigen::Vector2d expected = (T * on_sheet_m).hnormalized();
    const double off_px = camera.fx_px * (expected - Eigen::Vector2d(pixels.ray_x[i], pixels.ray_y[i])).norm();
    ASSERT_LT(off_px, 0.02) << pixels.x_px[i] << " " << pixels.y_px[i];
    ASSERT_GT(camera.fx_px * (expected - seen.hnormalized()).norm(), 0.05) << "there is something to correct";
  }
}

/// Bands of rows, each from where the camera is meanwhile.
test::Picture roll_out(const test::Scene& scene, const Eigen::Vector3d& velocity_m_s) {
  constexpr int kBand_rows = 6;
  test::Picture whole = test::render(scene, 1);
  for (int row = 0; row < 240; row += kBand_rows) {
    test::Scene then = scene;
    const double since_s = (row + 0.5 * (kBand_rows - 1) - 119.5) * kRowTime_s;
    for (std::size_t i = 0; i < 3; ++i)
      then.camera.position_m[i] += since_s * velocity_m_s(static_cast<Eigen::Index>(i));
    const test::Picture band = test::render(then, 1);
    for (int y = row; y < row + kBand_rows; ++y)
      std::copy_n(band.view().row(y), 320, whole.pixels.begin() + std::ptrdiff_t{y} * 320);
  }
  return whole;
}

TEST(RollingShutter, PoseIsThatOfTheMiddleRow) {
  test::Scene scene;
  scene.camera =
      test::look_at_landmark({.distance_m = 0.9, .tilt_rad = 0.5, .azimuth_rad = 0.7, .off_axis_y_rad = 0.22});
  scene.lens.width_px = 320, scene.lens.height_px = 240;
  scene.lens.fx_px = scene.lens.fy_px = 360, scene.lens.cx_px = 159.5, scene.lens.cy_px = 119.5;
  const Eigen::Vector3d velocity_m_s(1.5, 0.2, -0.5);
  const test::Picture picture = roll_out(scene, velocity_m_s);
  const CameraModel camera = small_camera();
  Detector detector(camera, LandmarkGeometry{});
  const auto seen = detector.find_landmarks(picture.view());
  ASSERT_TRUE(seen);

  const auto& [position_m, q] = scene.camera;
  const Eigen::Vector3d truth_m(position_m[0], position_m[1], position_m[2]);
  const Eigen::Matrix3d R_camera_landmark = Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix().transpose();
  FullSolver solver(camera, LandmarkGeometry{});
  const auto error_m = [&](const SheetMotion& motion) {
    int pixels = 100'000;
    const auto answer = solver.solve(picture.view(), seen->front(), nullptr, pixels, motion);
    return answer ? (answer->list[0].pose.T_landmark_camera.translation_m - truth_m).norm() : 1.0;
  };
  const double ignored_m = error_m({}), regarded_m = error_m(motion_of({0, 0, 0}, -R_camera_landmark * velocity_m_s));
  EXPECT_GT(ignored_m, 0.002);
  EXPECT_LT(regarded_m, 0.0006) << "bands of six rows leave steps of 0.3 mm";
  EXPECT_LT(regarded_m, 0.15 * ignored_m);
}

}  // namespace
}  // namespace ninedot
