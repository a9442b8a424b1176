#include "outputs/told_angles.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

namespace ninedot {
namespace {

constexpr double kDeg = std::numbers::pi / 180;
constexpr double k345_deg = 36.86989764584402;  // atan(3 / 4)

/// Turned by hand: x looks along (4, 3, 0) / 5, y upwards, z along (3, -4, 0) / 5. Rz(36.87 deg) Rx(90 deg).
Eigen::Matrix3d lying_on_its_side() {
  Eigen::Matrix3d R;
  R << 0.8, 0, 0.6, 0.6, 0, -0.8, 0, 1, 0;
  return R;
}

void expect_angles(const ToldAngles& told, const std::array<double, 3>& angles_deg) {
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(told.angles_deg[i], angles_deg[i], 1e-12) << i;
}

TEST(ToldAngles, AreInTheOrderOfTheirConvention) {
  const Eigen::Matrix3d R = lying_on_its_side(), none = Eigen::Matrix3d::Zero();
  expect_angles(told_angles(R, none, EulerConvention::kZyx), {k345_deg, 0, 90});
  expect_angles(told_angles(R, none, EulerConvention::kFanuc), {90, 0, k345_deg});
  expect_angles(told_angles(R, none, EulerConvention::kKuka), {k345_deg, 0, 90});
}

TEST(ToldAngles, APositivePitchLooksDown) {
  Eigen::Matrix3d R;  // its x goes down 4 for every 3 ahead
  R << 0.6, 0, 0.8, 0, 1, 0, -0.8, 0, 0.6;
  expect_angles(told_angles(R, Eigen::Matrix3d::Zero(), EulerConvention::kZyx), {0, 90 - k345_deg, 0});
}

/// The turns one after the other, as the manuals of the controllers have them: about fixed axes, and about new ones.
TEST(ToldAngles, TurnTheRobotBackToWhereItIs) {
  const Eigen::Matrix3d R =
      (Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, -2, 3).normalized()) * Eigen::AngleAxisd(2, Eigen::Vector3d::UnitZ()))
          .toRotationMatrix();
  const auto about = [](double angle_deg, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(angle_deg * kDeg, axis).toRotationMatrix();
  };
  const auto x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(), z = Eigen::Vector3d::UnitZ();
  const auto wpr = told_angles(R, Eigen::Matrix3d::Zero(), EulerConvention::kFanuc).angles_deg;
  Eigen::Matrix3d turned = about(wpr[0], x);
  turned = about(wpr[1], y) * turned;  // a fixed axis: from the left
  turned = about(wpr[2], z) * turned;
  EXPECT_TRUE(turned.isApprox(R, 1e-12));
  const auto abc = told_angles(R, Eigen::Matrix3d::Zero(), EulerConvention::kKuka).angles_deg;
  turned = about(abc[0], z);
  turned = turned * about(abc[1], y);  // the axis as it has become: from the right
  turned = turned * about(abc[2], x);
  EXPECT_TRUE(turned.isApprox(R, 1e-12));
}

TEST(ToldAngles, AreAsUncertainAsTheirDerivativesSay) {
  const Eigen::Matrix3d R =
      (Eigen::AngleAxisd(0.6, Eigen::Vector3d::UnitZ()) * Eigen::AngleAxisd(-1.1, Eigen::Vector3d::UnitY()) *
       Eigen::AngleAxisd(0.4, Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  Eigen::Matrix3d root;
  root << 2, 0.3, -0.1, 0, 1, 0.5, 0, 0, 3;
  const Eigen::Matrix3d covariance = 1e-6 * root * root.transpose();
  const auto textbook_rad = [](const Eigen::Matrix3d& M) {
    return Eigen::Vector3d(std::atan2(M(1, 0), M(0, 0)), std::asin(-M(2, 0)), std::atan2(M(2, 1), M(2, 2)));
  };
  constexpr double kStep_rad = 1e-6;
  Eigen::Matrix3d J;
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const auto turned = [&](double step_rad) {
      return textbook_rad(R * Eigen::AngleAxisd(step_rad, Eigen::Vector3d::Unit(axis)).toRotationMatrix());
    };
    J.col(axis) = (turned(kStep_rad) - turned(-kStep_rad)) / (2 * kStep_rad);
  }
  const Eigen::Vector3d sigma_deg = (J * covariance * J.transpose()).diagonal().cwiseSqrt() / kDeg;
  const ToldAngles zyx = told_angles(R, covariance, EulerConvention::kZyx);
  const ToldAngles fanuc = told_angles(R, covariance, EulerConvention::kFanuc);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(zyx.sigma_deg[i], sigma_deg(static_cast<Eigen::Index>(i)), 1e-6 * zyx.sigma_deg[i]);
    EXPECT_EQ(fanuc.sigma_deg[i], zyx.sigma_deg[2 - i]);
  }
}

TEST(ToldAngles, WhereThePitchIsAtItsPoleNothingIsKnownOfTheOthers) {
  Eigen::Matrix3d R;
  R << 0, 0, 1, 0, 1, 0, -1, 0, 0;
  const ToldAngles told = told_angles(R, 1e-6 * Eigen::Matrix3d::Identity(), EulerConvention::kZyx);
  expect_angles(told, {0, 90, 0});
  EXPECT_FALSE(told.sigma_deg[0] < 360);
  EXPECT_FALSE(told.sigma_deg[2] < 360);
  EXPECT_LT(told.sigma_deg[1], 0.06);
}

}  // namespace
}  // namespace ninedot
