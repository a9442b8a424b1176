#include "pipeline/verdict.h"

#include <gtest/gtest.h>

#include <limits>

namespace ninedot {
namespace {

PoseEstimate pose_of(double ambiguity, double sigma_m) {
  PoseEstimate pose;
  pose.T_landmark_camera.translation_m = {0, 2, 0};
  pose.covariance = Matrix6d::Identity() * (sigma_m * sigma_m / 3);
  pose.ambiguity = ambiguity;
  return pose;
}

TEST(Verdict, SaysTheFirstThingThatIsWrong) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  const TrustLimits limits;
  EXPECT_EQ(verdict_on(pose_of(0.009, 0.059), true, limits), Reason::kNone);
  EXPECT_EQ(verdict_on(pose_of(0.011, 0.059), true, limits), Reason::kAmbiguous);
  EXPECT_EQ(verdict_on(pose_of(0.009, 0.061), true, limits), Reason::kUncertain) << "3 % of 2 m";
  EXPECT_EQ(verdict_on(pose_of(0.011, 0.061), false, limits), Reason::kPoorFit);
  EXPECT_EQ(verdict_on(pose_of(kNan, 0.001), true, limits), Reason::kAmbiguous);
  EXPECT_EQ(verdict_on(pose_of(0, kNan), true, limits), Reason::kUncertain);
}

}  // namespace
}  // namespace ninedot
