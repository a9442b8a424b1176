#include "tests/bench/position_bound.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "tests/support/renderer.h"

namespace ninedot::bench {
namespace {

constexpr double kDeg = std::numbers::pi / 180;

/// The optical axis goes through P9.
Transform<frame::Landmark, frame::Camera> camera_at(double distance_m, double tilt_deg) {
  const double tilt_rad = tilt_deg * kDeg;
  Transform<frame::Landmark, frame::Camera> pose;
  pose.translation_m = distance_m * Eigen::Vector3d(std::sin(tilt_rad), std::cos(tilt_rad), 0);
  const Eigen::Vector3d z = -pose.translation_m.normalized();
  const Eigen::Vector3d x = z.cross(Eigen::Vector3d::UnitZ()).normalized();
  pose.rotation << x, z.cross(x), z;
  return pose;
}

double bound_mm(double distance_m, double tilt_deg, const PictureQuality& quality = {150, 2, 0.6}) {
  return 1000 * position_bound_m(CameraModel{}, LandmarkGeometry{}, camera_at(distance_m, tilt_deg), quality);
}

/// Computed by another program, from whole pictures differentiated numerically (docs/accuracy.md states the same
/// limits).
TEST(PositionBound, AgreesWithNumericallyDifferentiatedPictures) {
  EXPECT_NEAR(bound_mm(0.3, 5), 0.010, 0.0005);
  EXPECT_NEAR(bound_mm(1, 5), 0.49, 0.005);
  EXPECT_NEAR(bound_mm(1, 45), 0.09, 0.005);
  EXPECT_NEAR(bound_mm(2, 20), 1.0, 0.05);
  EXPECT_NEAR(bound_mm(3, 45), 1.4, 0.05);
  EXPECT_NEAR(bound_mm(7, 20), 23, 0.5);
}

TEST(PositionBound, GrowsWithNoiseAndFallsWithContrast) {
  const double reference_mm = bound_mm(2, 20);
  EXPECT_NEAR(bound_mm(2, 20, {150, 4, 0.6}), 2 * reference_mm, 1e-9);
  EXPECT_NEAR(bound_mm(2, 20, {75, 2, 0.6}), 2 * reference_mm, 0.01 * reference_mm);
  EXPECT_GT(bound_mm(2, 20, {150, 2, 1.5}), reference_mm);
}

TEST(PositionBound, SaysNothingWhenTheLandmarkIsOutOfThePicture) {
  auto pose = camera_at(1, 20);
  pose.translation_m.x() += 3;
  EXPECT_EQ(position_bound_m(CameraModel{}, LandmarkGeometry{}, pose, {150, 2, 0.6}), 0);
}

class PictureQualityOfRenderedScene : public testing::Test {
 protected:
  PictureQualityOfRenderedScene() {
    scene_.camera = test::look_at_landmark({.distance_m = 1.2, .tilt_rad = 25 * kDeg});
    scene_.sensor.tone = test::ToneCurve::kLinear;
    scene_.sensor.point_spread_px = 0.7;
    test::set_noise(scene_.sensor, 2.5);
  }
  std::optional<PictureQuality> measure() const {
    const test::Picture picture = test::render(scene_, 7);
    const auto& [w, x, y, z] = scene_.camera.quaternion_wxyz;
    const Transform<frame::Landmark, frame::Camera> pose{Eigen::Quaterniond(w, x, y, z).toRotationMatrix(),
                                                         Eigen::Vector3d(scene_.camera.position_m.data())};
    return measure_quality(picture.view(), CameraModel{}, LandmarkGeometry{}, pose);
  }
  test::Scene scene_;
};

TEST_F(PictureQualityOfRenderedScene, ContrastAndBlurAreWhatWasRendered) {
  const auto quality = measure();
  ASSERT_TRUE(quality);
  EXPECT_NEAR(quality->contrast_lsb, 255 * 0.85 * (0.90 - 0.04), 3);
  EXPECT_NEAR(quality->blur_px, std::sqrt(0.7 * 0.7 + 1.0 / 12), 0.05);
}

TEST_F(PictureQualityOfRenderedScene, NoiseIsThatOfThePaper) {
  const auto quality = measure();
  ASSERT_TRUE(quality);
  const double light = 0.85 * 0.90;
  const double paper_noise_lsb = 255 * std::sqrt(scene_.sensor.noise_a * light + scene_.sensor.noise_b);
  EXPECT_NEAR(quality->noise_lsb, paper_noise_lsb, 0.1 * paper_noise_lsb);
}

TEST_F(PictureQualityOfRenderedScene, AHardShadowIsNeitherNoiseNorBlur) {
  const auto even = measure();
  scene_.light.shadows.push_back({.direction_rad = 0.3, .offset_m = 0.03, .width_m = 0.05});
  const auto shadowed = measure();
  ASSERT_TRUE(even && shadowed);
  EXPECT_NEAR(shadowed->noise_lsb, even->noise_lsb, 0.3 * even->noise_lsb);
  EXPECT_NEAR(shadowed->blur_px, even->blur_px, 0.15);
}

TEST_F(PictureQualityOfRenderedScene, NothingIsMeasuredWithoutContrast) {
  scene_.light.level = 0.01;
  EXPECT_FALSE(measure());
}

}  // namespace
}  // namespace ninedot::bench
