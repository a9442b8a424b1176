#include "pose/observation_of_pose.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "detect/detector.h"
#include "tests/support/renderer.h"

namespace ninedot {
namespace {

TEST(ObservationOfPose, IsWhatTheDetectorSeesInThePicture) {
  for (const double tilt_rad : {0.2, 0.9}) {
    test::Scene scene;
    scene.camera =
        test::look_at_landmark({.distance_m = 1.2, .tilt_rad = tilt_rad, .azimuth_rad = 0.6, .roll_rad = 0.1});
    const test::Picture picture = test::render(scene, 1);
    Detector detector(CameraModel{}, LandmarkGeometry{});
    const auto seen = detector.find_landmarks(picture.view());
    ASSERT_TRUE(seen.has_value());
    const auto& [w, x, y, z] = scene.camera.quaternion_wxyz;
    const Transform<frame::Landmark, frame::Camera> T{Eigen::Quaterniond(w, x, y, z).toRotationMatrix(),
                                                      Eigen::Vector3d(scene.camera.position_m.data())};
    std::array<double, kDotCount> visible;
    visible.fill(1);
    visible[4] = 0.2;
    const LandmarkObservation expected = observation_of(T.inverse(), visible, CameraModel{}, LandmarkGeometry{});
    EXPECT_EQ(expected.seen_count, 8);
    EXPECT_TRUE(expected.from_pose);
    EXPECT_FALSE(expected.dots[4].seen);
    for (std::size_t i = 0; i < kDotCount; ++i) {
      const DotObservation &a = expected.dots[i], &b = seen->front().dots[i];
      EXPECT_LT((a.centroid_px - b.centroid_px).norm(), 0.25) << "dot " << i;
      EXPECT_NEAR(a.semi_major_px, b.semi_major_px, 0.04 * b.semi_major_px + 0.2) << "dot " << i;
      EXPECT_NEAR(a.semi_minor_px, b.semi_minor_px, 0.04 * b.semi_minor_px + 0.2) << "dot " << i;
      if (tilt_rad > 0.5) {
        EXPECT_LT(std::abs(std::sin(a.angle_rad - b.angle_rad)), 0.03) << "dot " << i;
      }
    }
    for (const std::size_t i : {0U, 3U}) {
      const Eigen::Vector3d c(LandmarkGeometry{}.centre_m(i).x(), LandmarkGeometry{}.centre_m(i).y(), 1);
      const Eigen::Vector2d p = (expected.H_ray_plane * c).hnormalized(),
                            q = (seen->front().H_ray_plane * c).hnormalized();
      EXPECT_LT((p - q).norm() * 720, 1.5) << "dot " << i;
    }
  }
}

}  // namespace
}  // namespace ninedot
