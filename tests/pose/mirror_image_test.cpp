#include "pose/mirror_image.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <array>
#include <cmath>

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

/// Root mean square distance [px] of the dots in sight between two poses, at a focal length of 720 px.
double apart_px(const CameraFromLandmark& a, const CameraFromLandmark& b,
                const std::array<double, kDotCount>& visible) {
  double sum = 0, count = 0;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d C = LandmarkGeometry{}.centre_m(dot);
    const Eigen::Vector3d p(C.x(), 0, C.y());
    sum += visible[dot] * ((a * p).hnormalized() - (b * p).hnormalized()).squaredNorm();
    count += visible[dot];
  }
  return 720 * std::sqrt(sum / count);
}

TEST(MirrorImage, OfHalfALandmarkLooksLikeItsHalf) {
  const std::array<double, kDotCount> half{1, 1, 1, 1, 0, 0, 0, 0, 1};
  for (const double azimuth_rad : {0.3, 1.7, 4.0}) {
    const CameraFromLandmark T = seen_from(2, 0.5, azimuth_rad);
    const CameraFromLandmark of_half = mirror_image(T, LandmarkGeometry{}, half);
    EXPECT_GT(angle_between_rad(T, of_half), 0.2) << azimuth_rad;
    EXPECT_LT(apart_px(T, of_half, half), 0.8 * apart_px(T, mirror_image(T, LandmarkGeometry{}), half)) << azimuth_rad;
  }
}

TEST(MirrorImage, OfFourDotsIsThatOfAll) {
  const CameraFromLandmark T = seen_from(2, 0.5, 0.3);
  const CameraFromLandmark of_four = mirror_image(T, LandmarkGeometry{}, {1, 1, 1, 1, 0, 0, 0, 0, 0});
  EXPECT_EQ(angle_between_rad(of_four, mirror_image(T, LandmarkGeometry{})), 0);
}

/// Between a pose that is tilted by 0.3 rad and its mirror image, each dot known to a twentieth of a pixel.
double evidence_at(double distance_m, double pattern_px) {
  constexpr double kFocal_px = 600;
  const CameraFromLandmark T = seen_from(distance_m, 0.3, 0.3);
  DotSightings dots;
  for (DotSighting& dot : dots) dot.information = Eigen::Matrix2d::Identity() * std::pow(20 * kFocal_px, 2);
  const LandmarkGeometry landmark;
  return evidence_of_places(T, mirror_image(T, landmark), dots, pattern_px / kFocal_px, landmark);
}

TEST(EvidenceOfPlaces, IsWithoutDoubtNearByAndLittleFarAway) {
  EXPECT_GT(evidence_at(1.0, 0.1), 100);
  EXPECT_LT(evidence_at(6.0, 0.1), 9) << "kUndecided_chi2: the dots of the two lie 0.05 px apart";
  EXPECT_GT(evidence_at(6.0, 0.1), 0.5);
  EXPECT_LT(evidence_at(9.0, 0.1), evidence_at(6.0, 0.1));
  EXPECT_GT(evidence_at(6.0, 0), 1.5 * evidence_at(6.0, 0.1)) << "a picture without a pattern says more";
}

TEST(EvidenceOfPlaces, IsNoneOfDotsThatAreNotSeen) {
  const CameraFromLandmark T = seen_from(1, 0.3, 0.3);
  EXPECT_EQ(evidence_of_places(T, mirror_image(T, {}), DotSightings{}, 0.001, {}), 0);
}

TEST(PreferenceOfPlaces, IsForThePoseThatShowsTheDotsThere) {
  const CameraFromLandmark T = seen_from(1, 0.3, 0.3), mirror = mirror_image(T, {});
  DotSightings dots;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d C = LandmarkGeometry{}.centre_m(dot);
    dots[dot].ray = (T * Eigen::Vector3d(C.x(), 0, C.y())).hnormalized();
    dots[dot].information = 1e8 * Eigen::Matrix2d::Identity();
  }
  const double apart_chi2 = 1e8 * kDotCount * std::pow(apart_px(T, mirror, kAllInSight) / 720, 2);
  EXPECT_NEAR(preference_of_places(T, mirror, dots, {}), apart_chi2, 1e-6 * apart_chi2);
  EXPECT_NEAR(preference_of_places(mirror, T, dots, {}), -apart_chi2, 1e-6 * apart_chi2);
  for (DotSighting& dot : dots) dot.information.setZero();
  EXPECT_EQ(preference_of_places(T, mirror, dots, {}), 0) << "of dots that are not seen";
}

}  // namespace
}  // namespace ninedot
