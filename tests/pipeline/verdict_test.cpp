#include "pipeline/verdict.h"

#include <gtest/gtest.h>

#include <limits>

#include "geometry/transform.h"

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
  EXPECT_EQ(verdict_on(pose_of(0.009, 0.059), limits), Reason::kNone);
  EXPECT_EQ(verdict_on(pose_of(0.011, 0.059), limits), Reason::kAmbiguous);
  EXPECT_EQ(verdict_on(pose_of(0.009, 0.061), limits), Reason::kUncertain) << "3 % of 2 m";
  EXPECT_EQ(verdict_on(pose_of(0.011, 0.061), limits), Reason::kAmbiguous);
  EXPECT_EQ(verdict_on(pose_of(kNan, 0.001), limits), Reason::kAmbiguous);
  EXPECT_EQ(verdict_on(pose_of(0, kNan), limits), Reason::kUncertain);
}

/// A reading with the middle of the landmark there, in the camera's frame.
PoseCandidate reading_at(const Eigen::Vector3d& middle_m, double chi2_above) {
  PoseCandidate reading;
  const CameraFromLandmark T{exp_so3({0.3, 0.2, 0.1}), middle_m};
  reading.pose.T_landmark_camera = T.inverse();
  reading.chi2_above = chi2_above;
  return reading;
}

TEST(Verdict, AHeadMayTurnToAMirrorImageButNotToAnotherPlaceOrAnotherLandmark) {
  const TrustLimits limits;
  const auto sure = [&](const Eigen::Vector3d& other_m, double chi2_above, Reason verdict, double others_odds = 0) {
    PoseCandidates candidates;
    EXPECT_TRUE(candidates.list.try_push_back(reading_at({0.2, 0, 2}, 0)));
    EXPECT_TRUE(candidates.list.try_push_back(reading_at(other_m, chi2_above)));
    return is_place_sure(candidates, 0, verdict, others_odds, limits);
  };
  EXPECT_TRUE(sure({0.21, 0, 2}, 1, Reason::kAmbiguous));
  EXPECT_TRUE(sure({0.22, 0, 2.2}, 1, Reason::kAmbiguous)) << "nearer or farther";
  EXPECT_FALSE(sure({0.25, 0, 2}, 1, Reason::kAmbiguous));
  EXPECT_TRUE(sure({0.25, 0, 2}, 30, Reason::kAmbiguous)) << "excluded";
  EXPECT_TRUE(sure({0.25, 0, 2}, 1, Reason::kNone));
  EXPECT_FALSE(sure({0.2, 0, 2}, 1, Reason::kPoorFit));
  EXPECT_TRUE(sure({0.2, 0, 2}, 1, Reason::kUncertain)) << "how far, and at which tilt";
  EXPECT_FALSE(sure({0.25, 0, 2}, 1, Reason::kUncertain));
  EXPECT_FALSE(sure({0.2, 0, 2}, 1, Reason::kAmbiguous, 0.02)) << "it may be another landmark";
}

}  // namespace
}  // namespace ninedot
