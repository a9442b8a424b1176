#include "track/reading_odds.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "base/units.h"
#include "pose/mirror_image.h"

namespace ninedot {
namespace {

/// 2 m in front of the sheet, leaning by `tilt_rad`; the camera rolls by `roll_rad` about its axis.
CameraFromLandmark sheet_at(double tilt_rad, double roll_rad) {
  Eigen::Matrix3d frontal;
  frontal << -1, 0, 0, 0, 0, -1, 0, -1, 0;
  return {exp_so3({0, 0, roll_rad}) * exp_so3({0, tilt_rad, 0}) * frontal, {0, 0, 2}};
}

PoseCandidate reading(const CameraFromLandmark& T, double chi2_above = 0, double sigma = 1e-4) {
  PoseCandidate candidate;
  candidate.pose.T_landmark_camera = T.inverse();
  candidate.pose.covariance = Matrix6d::Identity() * sigma * sigma;
  candidate.chi2_above = chi2_above;
  return candidate;
}

ReadingOdds weigh(std::initializer_list<PoseCandidate> list, const UprightPrior& upright = {},
                  const NumberingCosts& past = {}) {
  PoseCandidates candidates;
  for (const PoseCandidate& candidate : list) EXPECT_TRUE(candidates.list.try_push_back(candidate));
  return weigh_readings(candidates, 0, past, {}, &upright);
}

constexpr double kLean_rad = 0.3;

TEST(ReadingOdds, ALevelCameraWithOneSolutionHasNoOther) {
  const ReadingOdds odds = weigh({reading(sheet_at(kLean_rad, 0))});
  EXPECT_LT(odds.ambiguity, 1e-9);
  EXPECT_EQ(odds.mirror_weight, 0);
}

TEST(ReadingOdds, TheMirrorImageCountsByItsChiSquared) {
  const ReadingOdds odds = weigh({reading(sheet_at(kLean_rad, 0)), reading(sheet_at(-kLean_rad, 0), 4)});
  EXPECT_NEAR(odds.ambiguity, std::exp(-2) / (1 + std::exp(-2)), 1e-3);
  ASSERT_TRUE(odds.rival.has_value());
  EXPECT_NEAR(odds.rival->odds, odds.ambiguity, 1e-6);
  EXPECT_LT(angle_between_rad(odds.rival->T_landmark_camera.inverse(), sheet_at(-kLean_rad, 0)), 1e-9);
}

TEST(ReadingOdds, AMirrorImageWithinTheCovarianceIsNoneOfItsOwn) {
  EXPECT_LT(weigh({reading(sheet_at(0.02, 0), 0, 0.05), reading(sheet_at(-0.02, 0), 0)}).ambiguity, 1e-9);
  EXPECT_NEAR(weigh({reading(sheet_at(0.02, 0), 0, 0.002), reading(sheet_at(-0.02, 0), 0)}).ambiguity, 0.5, 1e-3);
}

TEST(ReadingOdds, ARollOfHalfAnEighthLeavesTwoNumberings) {
  const auto at = [](double roll_deg, double sigma_deg) {
    return weigh({reading(sheet_at(0.01, roll_deg * kRadPerDeg))}, {0, sigma_deg * kRadPerDeg}).ambiguity;
  };
  EXPECT_NEAR(at(22.5, 5), 0.5, 0.05);
  EXPECT_LT(at(15, 5), 1e-3);
  EXPECT_GT(at(20, 5), 0.01);
  EXPECT_GT(at(25, 5), 0.01) << "five sigma";
  EXPECT_GT(at(17, 14), 0.1) << "a mount that may lean by as much says less";
}

TEST(ReadingOdds, TheRivalOfARolledCameraIsTheNeighbourOfItsNumbering) {
  const CameraFromLandmark T = sheet_at(kLean_rad, 0.4);
  const ReadingOdds odds = weigh({reading(T)});
  ASSERT_TRUE(odds.rival.has_value());
  const CameraFromLandmark rival = odds.rival->T_landmark_camera.inverse();
  EXPECT_NEAR(angle_between_rad(rival, T), std::numbers::pi / 4, 1e-9);
  EXPECT_LT((rival.rotation.col(1) - T.rotation.col(1)).norm(), 1e-9) << "the same sheet, turned in its plane";
  const LandmarkGeometry landmark;
  const auto dot = [&](const CameraFromLandmark& pose, std::size_t k) {
    return Eigen::Vector3d(pose * Eigen::Vector3d(landmark.centre_m(k).x(), 0, landmark.centre_m(k).y()));
  };
  const double to_next = (dot(rival, 0) - dot(T, 1)).norm(), to_last = (dot(rival, 0) - dot(T, 7)).norm();
  EXPECT_LT(std::min(to_next, to_last), 1e-9) << "its P1 is a dot that is there";
}

TEST(ReadingOdds, WhatATracksWayHasExcludedStaysExcluded) {
  const PoseCandidate rolled = reading(sheet_at(kLean_rad, 30 * kRadPerDeg));
  EXPECT_GT(weigh({rolled}).ambiguity, 0.9) << "alone, another numbering is likelier";
  NumberingCosts began_level{0, 81, 324, 729, 1296, 729, 324, 81};
  EXPECT_LT(weigh({rolled}, {}, began_level).ambiguity, 1e-6);
}

TEST(ReadingOdds, AreNumbersHoweverSureTheMountIsAndHoweverWrong) {
  const ReadingOdds odds = weigh({reading(sheet_at(kLean_rad, 1.4))}, {0, 0.1 * kRadPerDeg});
  EXPECT_NEAR(odds.ambiguity, 1, 1e-9);
  ASSERT_TRUE(odds.rival.has_value());
  EXPECT_TRUE(odds.rival->odds > 0.1 && odds.rival->odds <= 1) << odds.rival->odds;
}

}  // namespace
}  // namespace ninedot
