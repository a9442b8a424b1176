#include "geometry/euler_angles.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <numbers>

#include "base/units.h"
#include "geometry/transform.h"
#include "tests/support/random.h"

namespace ninedot {
namespace {

using Eigen::AngleAxisd;
using Eigen::Vector3d;

Eigen::Matrix3d about(double angle_rad, const Vector3d& axis) { return AngleAxisd(angle_rad, axis).toRotationMatrix(); }

Eigen::Matrix3d any_rotation(test::Random& random) {
  return Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal())
      .normalized()
      .toRotationMatrix();
}

TEST(EulerAngles, OfKukaTurnAboutZAndThenAboutTheNewYAndTheNewX) {
  const double a = 0.3, b = -0.7, c = 1.9;
  const Eigen::Matrix3d R = about(a, Vector3d::UnitZ()) * about(b, Vector3d::UnitY()) * about(c, Vector3d::UnitX());
  EXPECT_TRUE(rotation_of(KukaAngles{a, b, c}).isApprox(R, 1e-14));
}

TEST(EulerAngles, OfFanucTurnAboutTheFixedXAndThenAboutTheFixedYAndTheFixedZ) {
  const double w = 0.3, p = -0.7, r = 1.9;
  Eigen::Matrix3d R = about(w, Vector3d::UnitX());
  R = about(p, Vector3d::UnitY()) * R;  // from the left: the axes stay
  R = about(r, Vector3d::UnitZ()) * R;
  EXPECT_TRUE(rotation_of(FanucAngles{w, p, r}).isApprox(R, 1e-14));
}

TEST(EulerAngles, OfABodyLeadToTheLeftAndDownwards) {
  const Vector3d ahead = rotation_of(YawPitchRoll{90 * kRadPerDeg, 0, 0}) * Vector3d::UnitX();
  EXPECT_TRUE(ahead.isApprox(Vector3d::UnitY(), 1e-14)) << "yaw of 90 degrees looks to the left";
  EXPECT_LT((rotation_of(YawPitchRoll{0, 10 * kRadPerDeg, 0}) * Vector3d::UnitX()).z(), 0);
  EXPECT_GT((rotation_of(YawPitchRoll{0, 0, 10 * kRadPerDeg}) * Vector3d::UnitY()).z(), 0) << "the left side goes up";
}

TEST(EulerAngles, ComeBackFromEveryRotation) {
  test::Random random(11);
  for (int i = 0; i < 10000; ++i) {
    const Eigen::Matrix3d R = any_rotation(random);
    EXPECT_LT((rotation_of(yaw_pitch_roll(R)) - R).norm(), 1e-12);
    EXPECT_LT((rotation_of(fanuc_angles(R)) - R).norm(), 1e-12);
    EXPECT_LT((rotation_of(kuka_angles(R)) - R).norm(), 1e-12);
  }
}

TEST(EulerAngles, AreThoseThatMadeTheRotation) {
  test::Random random(12);
  for (int i = 0; i < 10000; ++i) {
    const YawPitchRoll angles{random.uniform(-3.1, 3.1), random.uniform(-1.5, 1.5), random.uniform(-3.1, 3.1)};
    const YawPitchRoll back = yaw_pitch_roll(rotation_of(angles));
    EXPECT_NEAR(back.yaw_rad, angles.yaw_rad, 1e-12);
    EXPECT_NEAR(back.pitch_rad, angles.pitch_rad, 1e-12);
    EXPECT_NEAR(back.roll_rad, angles.roll_rad, 1e-12);
  }
}

TEST(EulerAngles, AreARotationInGimbalLockAndNextToIt) {
  test::Random random(13);
  for (const double off_rad : {0.0, 1e-12, 1e-9, 0.99e-7, 1.01e-7, 1e-6, 1e-4})
    for (const double side : {-1.0, 1.0})
      for (int i = 0; i < 200; ++i) {
        const YawPitchRoll angles{random.uniform(-3, 3), side * (std::numbers::pi / 2 - off_rad),
                                  random.uniform(-3, 3)};
        const Eigen::Matrix3d R = rotation_of(angles);
        const YawPitchRoll back = yaw_pitch_roll(R);
        EXPECT_NEAR(back.pitch_rad, angles.pitch_rad, 1e-7);
        EXPECT_LT((rotation_of(back) - R).norm(), 3e-7) << off_rad;
        if (off_rad < 0.9e-7) {
          EXPECT_EQ(back.roll_rad, 0);
          EXPECT_EQ(fanuc_angles(R).w_rad, 0);
          EXPECT_EQ(kuka_angles(R).c_rad, 0);
        }
      }
}

TEST(EulerAngles, CovarianceIsThatOfDifferences) {
  test::Random random(14);
  for (int i = 0; i < 200; ++i) {
    const YawPitchRoll at{random.uniform(-2.9, 2.9), random.uniform(-1.3, 1.3), random.uniform(-2.9, 2.9)};
    const Eigen::Matrix3d R = rotation_of(at);
    Eigen::Matrix3d J;
    constexpr double kStep_rad = 1e-6;
    for (int axis = 0; axis < 3; ++axis) {
      const YawPitchRoll a = yaw_pitch_roll(R * exp_so3(-kStep_rad * Vector3d::Unit(axis)));
      const YawPitchRoll b = yaw_pitch_roll(R * exp_so3(kStep_rad * Vector3d::Unit(axis)));
      J.col(axis) =
          Vector3d(b.yaw_rad - a.yaw_rad, b.pitch_rad - a.pitch_rad, b.roll_rad - a.roll_rad) / (2 * kStep_rad);
    }
    const Eigen::Matrix3d root = Eigen::Matrix3d::Identity() + 0.3 * any_rotation(random);
    const Eigen::Matrix3d covariance = root * root.transpose();
    const Eigen::Matrix3d expected = J * covariance * J.transpose();
    EXPECT_LT((covariance_of_angles(at, covariance) - expected).norm(), 1e-6 * expected.norm());
  }
}

}  // namespace
}  // namespace ninedot
