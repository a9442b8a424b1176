#include "track/pose_mode.h"

#include <gtest/gtest.h>

#include <cmath>

namespace ninedot {
namespace {

TEST(PoseMode, HalvesLieOnBothSidesAndTogetherAreTheWhole) {
  PoseMode mode;
  mode.motion.T_world_camera.translation_m = {0.1, 2, 1};
  MotionCovariance root = 0.01 * MotionCovariance::Identity();
  root(0, 0) = 0.2;
  root(6, 0) = 0.1;  // who is further aside goes faster
  mode.covariance = root * root.transpose();
  const Eigen::Vector3d plane = Eigen::Vector3d::Zero(), across = Eigen::Vector3d::UnitX();
  EXPECT_FALSE(mode.halved(plane, across, 0.32).has_value()) << "half a sigma: 31 % lie beyond";
  const auto halves = mode.halved(plane, across, 1e-4);
  ASSERT_TRUE(halves.has_value());
  EXPECT_GT((*halves)[0].motion.T_world_camera.translation_m.x(), 0.1);
  EXPECT_LT((*halves)[1].motion.T_world_camera.translation_m.x(), 0);
  EXPECT_NEAR(std::exp((*halves)[1].log_weight()), 0.3085, 1e-4);
  double weight = 0;
  MotionStep mean = MotionStep::Zero();
  MotionCovariance second = MotionCovariance::Zero();
  for (const PoseMode& half : *halves) {
    const MotionStep apart = step_between(mode.motion, half.motion);
    weight += std::exp(half.log_weight());
    mean += std::exp(half.log_weight()) * apart;
    second += std::exp(half.log_weight()) * (half.covariance + apart * apart.transpose());
  }
  EXPECT_NEAR(weight, 1, 1e-12);
  EXPECT_LT(mean.norm(), 1e-12);
  EXPECT_LT((second - mode.covariance).norm(), 1e-12);
}

}  // namespace
}  // namespace ninedot
