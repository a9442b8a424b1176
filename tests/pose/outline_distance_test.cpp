#include "pose/outline_distance.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "geometry/disc.h"
#include "pose/outline_columns.h"
#include "tests/support/renderer.h"

namespace ninedot {
namespace {

CameraModel distorted_camera() {
  CameraModel camera;
  camera.k = {-0.21, 0.07, 0.001, -0.0008, 0.02};
  return camera;
}

CameraFromLandmark pose(double distance_m = 1.1) {
  const auto view = test::look_at_landmark({.distance_m = distance_m,
                                            .tilt_rad = 0.6,
                                            .azimuth_rad = 0.7,
                                            .roll_rad = 0.1,
                                            .off_axis_x_rad = 0.15,
                                            .off_axis_y_rad = -0.1});
  const auto& [w, x, y, z] = view.quaternion_wxyz;
  return Transform<frame::Landmark, frame::Camera>{Eigen::Quaterniond(w, x, y, z).toRotationMatrix(),
                                                   Eigen::Vector3d(view.position_m.data())}
      .inverse();
}

/// Pixels exactly on the outlines of some dots.
struct OnOutline {
  std::size_t dot;
  Eigen::Vector2d pixel_px;
};
std::vector<OnOutline> pixels_on_outlines(const CameraModel& camera, const CameraFromLandmark& T) {
  const LandmarkGeometry landmark;
  std::vector<OnOutline> pixels;
  for (const std::size_t dot : {0U, 3U, 8U})
    for (int i = 0; i < 8; ++i) {
      const Eigen::Vector2d towards(std::cos(0.785 * i), std::sin(0.785 * i));
      const Eigen::Vector2d at_m = landmark.centre_m(dot) + landmark.radius_m(dot) * towards;
      pixels.push_back({dot, camera.pixel_from_normalised(project_plane_point(T, at_m))});
    }
  return pixels;
}

double distance_px(const CameraModel& camera, const CameraFromLandmark& T, const OnOutline& at,
                   const SheetMotion& motion = {}) {
  return outline_distance(camera, {}, T, at.dot, at.pixel_px, motion)->distance_px;
}

TEST(OutlineDistance, IsZeroOnTheOutlineAndOnePixelBesideIt) {
  const CameraModel camera = distorted_camera();
  for (const OnOutline& at : pixels_on_outlines(camera, pose())) {
    EXPECT_NEAR(distance_px(camera, pose(), at), 0, 1e-9);
    const Eigen::Vector2d middle_px =
        camera.pixel_from_normalised(project_plane_point(pose(), LandmarkGeometry{}.centre_m(at.dot)));
    // Along the gradient, which differs from the way to the middle by the ellipse's shape.
    double most = 0;
    for (int i = 0; i < 64; ++i) {
      const Eigen::Vector2d step(std::cos(0.098 * i), std::sin(0.098 * i));
      most = std::max(most, distance_px(camera, pose(), {at.dot, at.pixel_px + step}));
    }
    EXPECT_NEAR(most, 1, 0.04) << (at.pixel_px - middle_px).norm();
  }
}

TEST(OutlineDistance, DerivativesByPoseIntrinsicsAndRowTimeEqualCentralDifferences) {
  const CameraModel camera = distorted_camera();
  const CameraFromLandmark T = pose();
  for (const OnOutline& at : pixels_on_outlines(camera, T)) {
    const OutlineDistance exact = *outline_distance(camera, {}, T, at.dot, at.pixel_px);
    for (int i = 0; i < kPoseUnknowns; ++i) {
      UnknownVector step = UnknownVector::Zero();
      step(i) = 1e-6;
      OutlineState more, less;
      more.T_camera_landmark = less.T_camera_landmark = T;
      more.apply(step), less.apply(-step);
      const double numeric =
          (distance_px(camera, more.T_camera_landmark, at) - distance_px(camera, less.T_camera_landmark, at)) / 2e-6;
      EXPECT_NEAR(exact.by_pose(i), numeric, 1e-4 * exact.by_pose.norm()) << "pose " << i;
    }
    const std::array<double CameraModel::*, 4> matrix{&CameraModel::fx_px, &CameraModel::fy_px, &CameraModel::cx_px,
                                                      &CameraModel::cy_px};
    for (int i = 0; i < kIntrinsics - 3; ++i) {
      const double step = i < 4 ? 1e-3 : 1e-6;
      const auto moved = [&](double by) {
        CameraModel c = camera;
        (i < 4 ? c.*matrix[static_cast<std::size_t>(i)] : c.k[static_cast<std::size_t>(i - 4)]) += by;
        return distance_px(c, T, at);
      };
      const double numeric = (moved(step) - moved(-step)) / (2 * step);
      EXPECT_NEAR(exact.by_intrinsics(i), numeric, 1e-4 * (1e-2 + std::abs(numeric))) << "intrinsic " << i;
    }
  }
}

TEST(OutlineDistance, DerivativeByRowTimeEqualsCentralDifferences) {
  const CameraModel camera = distorted_camera();
  SheetMotion motion{{0.5, -0.3, 0.8}, {0.4, -0.2, 0.7}, 0, 239.5};
  for (const OnOutline& at : pixels_on_outlines(camera, pose())) {
    const double exact = outline_distance(camera, {}, pose(), at.dot, at.pixel_px, motion)->by_row_time_px_s;
    const auto at_row_time = [&](double row_time_s) {
      SheetMotion m = motion;
      m.row_time_s = row_time_s;
      return distance_px(camera, pose(), at, m);
    };
    const double numeric = (at_row_time(1e-7) - at_row_time(-1e-7)) / 2e-7;
    EXPECT_NEAR(exact, numeric, 1e-3 * std::abs(numeric) + 1e-3);
  }
}

TEST(OutlineDistance, AgreesWithTheColumnsThatTheSolverUses) {
  const CameraModel camera;                // without distortion, as the columns' rays come from a table
  const CameraFromLandmark T = pose(0.5);  // whole dots' columns know of blur what a straight edge does not
  test::Scene scene;
  const test::Picture picture = test::render(scene, 1);
  const RayTable rays(camera);
  OutlinePixels pixels(12000);
  collect_outline_pixels(picture.view(), camera, rays, {}, T, 2, 1, {}, {}, pixels);
  OutlineState state;
  state.T_camera_landmark = T;
  int compared = 0;
  for (const OutlineGroup& group : pixels.groups) {
    const DotView view(pixels, {}, state, group.dot);
    const BlurredDisc disc(pixels, {}, state, group.dot, Asked::kState);
    ColumnBatches batches{};
    const auto first = static_cast<std::size_t>(group.first);
    fill_columns(pixels, group, view, disc, {first, 1}, Asked::kState, batches);
    const OutlineColumns& columns = batches[0];
    const Eigen::Vector2d pixel_px(static_cast<double>(pixels.x_px[first]), static_cast<double>(pixels.y_px[first]));
    const OutlineDistance exact = *outline_distance(camera, {}, T, group.dot, pixel_px);
    const auto brighter = static_cast<double>(-columns[kStateColumn + 6][0]);
    if (!(brighter > 1e-3)) continue;
    ++compared;
    Eigen::Matrix<double, 1, kPoseUnknowns> by_pose;  // along the sheet's axes
    by_pose << exact.by_pose.head<3>() * T.rotation, exact.by_pose.tail<3>() * T.rotation;
    for (std::size_t i = 0; i < kPoseUnknowns; ++i)
      EXPECT_NEAR(static_cast<double>(columns[kStateColumn + i][0]) / brighter, by_pose(static_cast<Eigen::Index>(i)),
                  0.01 * by_pose.norm())
          << "unknown " << i << " of dot " << int{group.dot};
  }
  EXPECT_GT(compared, 20);
}

TEST(OutlineDistance, RefusesWhatCannotBeSeen) {
  const CameraModel camera;
  CameraFromLandmark behind = pose();
  behind.translation_m = -behind.translation_m;
  EXPECT_EQ(outline_distance(camera, {}, behind, 0, {320, 240}).error().code, Errc::kPoseDegenerate);
}

}  // namespace
}  // namespace ninedot
