#include "pose/mirror_image.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "base/units.h"

namespace ninedot {
namespace {

/// The sheet before the camera, aside of the optical axis, its normal turned away from the line of sight.
CameraFromLandmark seen_from(double distance_m, double tilt_rad, double azimuth_rad) {
  const Eigen::Vector3d sight = Eigen::Vector3d(-0.1, 0.08, 1).normalized();
  const Eigen::Vector3d tilt_axis =
      Eigen::AngleAxisd(azimuth_rad, sight) * sight.cross(Eigen::Vector3d::UnitY()).normalized();
  CameraFromLandmark T;
  T.rotation << -1, 0, 0, 0, 0, -1, 0, -1, 0;  // upright: its normal towards the camera
  T.rotation = Eigen::Quaterniond::FromTwoVectors(T.rotation.col(1), -sight) * T.rotation;
  T.rotation = Eigen::AngleAxisd(tilt_rad, tilt_axis) * T.rotation;
  T.translation_m = distance_m * sight;
  return T;
}

/// From 5 degrees to nothing perspective leaves the centres alone one solution; the outlines may see two.
TEST(MirrorImage, HasItsNormalOnTheOtherSideOfTheLineOfSightAtEveryTilt) {
  for (const double distance_m : {0.7, 1.5, 4.0})
    for (const double tilt_deg : {0.5, 1.0, 2.0, 5.0, 15.0, 40.0})
      for (const double azimuth_rad : {0.3, 1.7, 4.0}) {
        const CameraFromLandmark T = seen_from(distance_m, tilt_deg * kRadPerDeg, azimuth_rad);
        const CameraFromLandmark mirror = mirror_image(T, LandmarkGeometry{});
        const Eigen::Vector3d sight = T.translation_m.normalized(), normal = T.rotation.col(1);
        const Eigen::Vector3d expected = 2 * normal.dot(sight) * sight - normal, found = mirror.rotation.col(1);
        // Perspective moves it towards the line of sight.
        EXPECT_GT(found.dot(expected), found.dot(normal)) << distance_m << " m, " << tilt_deg << " degrees";
        EXPECT_GT(angle_between_rad(T, mirror), tilt_deg * kRadPerDeg)
            << distance_m << " m, " << tilt_deg << " degrees";
        EXPECT_LT(angle_between_rad(T, mirror), 2.2 * tilt_deg * kRadPerDeg);
      }
}

}  // namespace
}  // namespace ninedot
