#include "geometry/planar_pose.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "geometry/landmark.h"

namespace ninedot {
namespace {

constexpr double kRad = std::numbers::pi / 180;

/// A camera that looks about at the landmark: `tilt` from the sheet's normal towards `azimuth`, rolled, and turned away
/// a little.
CameraFromLandmark look(double distance_m, double tilt_rad, double azimuth_rad, double roll_rad,
                        const Eigen::Vector3d& turn_rad = Eigen::Vector3d::Zero()) {
  const Eigen::Vector3d position =
      distance_m * Eigen::Vector3d(std::sin(tilt_rad) * std::cos(azimuth_rad), std::cos(tilt_rad),
                                   std::sin(tilt_rad) * std::sin(azimuth_rad));
  const Eigen::Vector3d forward = -position.normalized();
  const Eigen::Vector3d right = forward.cross(Eigen::Vector3d(0.01, 0.02, 1)).normalized();
  Eigen::Matrix3d R;  // rows: camera axes in the landmark frame
  R << right.transpose(), forward.cross(right).transpose(), forward.transpose();
  R = exp_so3(turn_rad) * exp_so3(Eigen::Vector3d(0, 0, roll_rad)) * R;
  return {R, -(R * position)};
}

std::vector<PlanePoint> observe(const CameraFromLandmark& T, double sigma, std::mt19937_64& random,
                                std::size_t count = kDotCount) {
  std::normal_distribution<double> noise(0, 1);
  const LandmarkGeometry landmark;
  std::vector<PlanePoint> points;
  for (std::size_t dot = 0; dot < count; ++dot) {
    const Eigen::Vector2d m = landmark.centre_m(dot);
    const Eigen::Vector2d seen = (T * Eigen::Vector3d(m.x(), 0, m.y())).hnormalized();
    points.push_back({m, seen + sigma * Eigen::Vector2d(noise(random), noise(random)), 1.0});
  }
  return points;
}

double rotation_error_rad(const CameraFromLandmark& a, const CameraFromLandmark& b) {
  return log_so3(a.rotation.transpose() * b.rotation).norm();
}

class PlanarPoseLaws : public testing::Test {
 protected:
  PlanarPoseLaws()
      : seed_(std::hash<std::string>{}(testing::UnitTest::GetInstance()->current_test_info()->name())),
        random_(seed_) {}
  double number(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  CameraFromLandmark any_pose(double max_tilt_deg = 78) {
    return look(std::exp(number(std::log(0.3), std::log(7))), number(0, max_tilt_deg) * kRad, number(-M_PI, M_PI),
                number(-M_PI, M_PI), Eigen::Vector3d(number(-0.2, 0.2), number(-0.2, 0.2), 0));
  }
  std::size_t seed_;
  std::mt19937_64 random_;
};

TEST_F(PlanarPoseLaws, RecoversExactPosesFromNineDots) {
  for (int run = 0; run < 2000; ++run) {
    const CameraFromLandmark truth = any_pose();
    const auto points = observe(truth, 0, random_);
    const auto poses = solve_planar_pose(points);
    ASSERT_TRUE(poses.has_value()) << "seed " << seed_ << " run " << run;
    const CameraFromLandmark& T = (*poses)[0].T_camera_landmark;
    ASSERT_LT((*poses)[0].rms, 1e-10) << "seed " << seed_ << " run " << run;
    ASSERT_LT((T.translation_m - truth.translation_m).norm(), 1e-6 * truth.translation_m.norm()) << "seed " << seed_;
    ASSERT_LT(rotation_error_rad(T, truth), 1e-4) << "seed " << seed_ << " run " << run;
  }
}

/// Where noise leaves no doubt which of both it is.
TEST_F(PlanarPoseLaws, TheLikelierOneIsTheFirstOfBoth) {
  int compared = 0;
  for (int run = 0; run < 500; ++run) {
    const auto points = observe(any_pose(), 1e-4, random_);
    const auto both = solve_planar_pose(points);
    const auto one = solve_likelier_planar_pose(points);
    ASSERT_EQ(both.has_value(), one.has_value()) << "seed " << seed_ << " run " << run;
    if (!both || (*both)[1].rms < 1.5 * (*both)[0].rms) continue;
    ++compared;
    ASSERT_NEAR(one->rms, (*both)[0].rms, 1e-9) << "seed " << seed_ << " run " << run;
  }
  EXPECT_GT(compared, 250);
}

TEST_F(PlanarPoseLaws, RecoversExactPosesFromFourRingDots) {
  for (int run = 0; run < 500; ++run) {
    const CameraFromLandmark truth = any_pose(70);
    auto points = observe(truth, 0, random_, kRingDotCount);
    std::shuffle(points.begin(), points.end(), random_);
    points.resize(4);
    const auto poses = solve_planar_pose(points);
    ASSERT_TRUE(poses.has_value()) << "seed " << seed_ << " run " << run;
    ASSERT_LT(rotation_error_rad((*poses)[0].T_camera_landmark, truth), 1e-3) << "seed " << seed_ << " run " << run;
  }
}

TEST_F(PlanarPoseLaws, BothPosesSeeThePrintedSideFromTheFrontAndAreSortedByRms) {
  for (int run = 0; run < 2000; ++run) {
    const CameraFromLandmark truth = any_pose();
    const auto points = observe(truth, 2e-4, random_);
    const auto poses = solve_planar_pose(points);
    ASSERT_TRUE(poses.has_value()) << "seed " << seed_ << " run " << run;
    ASSERT_LE((*poses)[0].rms, (*poses)[1].rms);
    for (const PlanarPose& pose : *poses) {
      EXPECT_GT(pose.T_camera_landmark.inverse().translation_m.y(), 0) << "seed " << seed_ << " run " << run;
      EXPECT_NEAR(pose.T_camera_landmark.rotation.determinant(), 1, 1e-9);
      for (const PlanePoint& p : points)
        EXPECT_GT((pose.T_camera_landmark * Eigen::Vector3d(p.plane_m.x(), 0, p.plane_m.y())).z(), 0);
    }
  }
}

// Noise of 0.1 px at f = 720. The true pose may be the second one where the landmark is small.
TEST_F(PlanarPoseLaws, OneOfThePosesIsNearTheTruthUnderNoise) {
  for (int run = 0; run < 1000; ++run) {
    const double distance_m = number(0.4, 7), tilt_rad = number(25, 70) * kRad;
    const CameraFromLandmark truth = look(distance_m, tilt_rad, number(-M_PI, M_PI), number(-M_PI, M_PI));
    const auto poses = solve_planar_pose(observe(truth, 0.1 / 720, random_));
    ASSERT_TRUE(poses.has_value()) << "seed " << seed_ << " run " << run;
    double best_rad = 10;
    for (const PlanarPose& pose : *poses)
      best_rad = std::min(best_rad, rotation_error_rad(pose.T_camera_landmark, truth));
    // Tilt comes from the axes' ratio b/a = cos(tilt): error = (sigma/a) / sin(tilt) / sqrt(4), here times six.
    const double a = 0.08 / distance_m;
    EXPECT_LT(best_rad, 6 * (0.1 / 720) / a / std::sin(tilt_rad)) << "seed " << seed_ << " run " << run;
  }
}

TEST_F(PlanarPoseLaws, FarLandmarkHasTwoPosesThatFitAlmostAlike) {
  for (int run = 0; run < 200; ++run) {
    const CameraFromLandmark truth = look(6, 40 * kRad, number(-M_PI, M_PI), number(-M_PI, M_PI));
    const auto poses = solve_planar_pose(observe(truth, 0, random_));
    ASSERT_TRUE(poses.has_value());
    // Both tilted by 40 degrees to opposite sides of the line of sight: 80 degrees apart.
    EXPECT_NEAR(rotation_error_rad((*poses)[0].T_camera_landmark, (*poses)[1].T_camera_landmark), 80 * kRad, 2 * kRad);
    EXPECT_LT((*poses)[1].rms, 0.1 / 720);  // a tenth of a pixel at f = 720: can't be told from noise
    EXPECT_GT((*poses)[1].rms, 100 * (*poses)[0].rms);
  }
}

TEST_F(PlanarPoseLaws, FrontalViewsAreSolvedWithoutLossOfPosition) {
  for (int run = 0; run < 500; ++run) {
    const CameraFromLandmark truth =
        look(number(0.3, 3), number(0, 0.5) * kRad, number(-M_PI, M_PI), number(-M_PI, M_PI));
    const auto poses = solve_planar_pose(observe(truth, 0.05 / 720, random_));
    ASSERT_TRUE(poses.has_value()) << "seed " << seed_ << " run " << run;
    // Five sigma of the scale: sigma / (a sqrt(16)) of the distance; tilt noise adds a second-order part.
    const double a = 0.08 / truth.translation_m.norm();
    EXPECT_NEAR((*poses)[0].T_camera_landmark.translation_m.norm() / truth.translation_m.norm(), 1,
                5 * 0.05 / 720 / a / 4 + 0.002)
        << "seed " << seed_ << " run " << run;
  }
}

Eigen::Matrix3d map_of(const CameraFromLandmark& T) {
  Eigen::Matrix3d H;
  H << T.rotation.col(0), T.rotation.col(2), T.translation_m;
  return H;
}

TEST_F(PlanarPoseLaws, AMapTellsItsDepthByItsScale) {
  for (int i = 0; i < 200; ++i) {
    const CameraFromLandmark T = any_pose(60);
    const double scale = number(0.1, 10);  // a map has none of its own
    EXPECT_NEAR(depth_of_origin(scale * map_of(T)) / T.translation_m.z(), 1, 0.15);
    const CameraFromLandmark frontal = look(number(0.3, 7), 0, 0, number(-M_PI, M_PI));
    EXPECT_NEAR(depth_of_origin(scale * map_of(frontal)) / frontal.translation_m.z(), 1, 1e-9);
  }
}

// Dots that lie within 20 px say where they are, and hardly how they are foreshortened.
TEST_F(PlanarPoseLaws, DepthOfADistantMapOutlastsItsNoise) {
  double most_off = 0, most_off_by_columns = 0;
  for (int i = 0; i < 200; ++i) {
    const CameraFromLandmark T = look(5, number(0, 0.5), number(-M_PI, M_PI), number(-0.3, 0.3));
    std::vector<PlanePoint> points = observe(T, 0.4 / 600, random_);
    for (const int hidden : {7, 3, 1}) points.erase(points.begin() + hidden);
    const auto H = fit_homography(points);
    ASSERT_TRUE(H);
    most_off = std::max(most_off, std::abs(depth_of_origin(*H) / T.translation_m.z() - 1));
    const double by_columns = (*H)(2, 2) / (0.5 * (H->col(0).norm() + H->col(1).norm()));
    most_off_by_columns = std::max(most_off_by_columns, std::abs(by_columns / T.translation_m.z() - 1));
  }
  EXPECT_LT(most_off, 0.2);
  EXPECT_GT(most_off_by_columns, 0.5) << "else the other way would do";
}

TEST_F(PlanarPoseLaws, ZeroWeightRemovesAPoint) {
  const CameraFromLandmark truth = look(1, 35 * kRad, 0.4, 0.2);
  auto points = observe(truth, 0, random_);
  points[3].seen += Eigen::Vector2d(0.1, -0.2);
  points[3].weight = 0;
  const auto poses = solve_planar_pose(points);
  ASSERT_TRUE(poses.has_value());
  EXPECT_LT(rotation_error_rad((*poses)[0].T_camera_landmark, truth), 1e-7);
}

TEST_F(PlanarPoseLaws, OrderOfPointsDoesNotMatter) {
  auto points = observe(any_pose(), 1e-4, random_);
  const auto before = solve_planar_pose(points);
  std::shuffle(points.begin(), points.end(), random_);
  const auto after = solve_planar_pose(points);
  ASSERT_TRUE(before.has_value() && after.has_value());
  EXPECT_LT(rotation_error_rad((*before)[0].T_camera_landmark, (*after)[0].T_camera_landmark), 1e-6)
      << "seed " << seed_;
}

TEST_F(PlanarPoseLaws, RefusesFewerThanFourPointsAndPointsOnALine) {
  const CameraFromLandmark truth = look(1, 0.5, 0.4, 0.2);
  auto points = observe(truth, 0, random_);
  const auto three = solve_planar_pose(std::span(points).first(3));
  ASSERT_FALSE(three.has_value());
  EXPECT_EQ(three.error().code, Errc::kPoseDegenerate);

  std::vector<PlanePoint> line;
  for (int i = 0; i < 6; ++i) {
    const Eigen::Vector2d m(0.01 * i, 0.02 * i);
    line.push_back({m, (truth * Eigen::Vector3d(m.x(), 0, m.y())).hnormalized(), 1.0});
  }
  EXPECT_FALSE(solve_planar_pose(line).has_value());

  std::vector<PlanePoint> one_place(6, points[0]);
  EXPECT_FALSE(solve_planar_pose(one_place).has_value());
}

TEST_F(PlanarPoseLaws, RefusesAMirroredLandmark) {
  for (int run = 0; run < 100; ++run) {
    auto points = observe(any_pose(60), 0, random_);
    for (PlanePoint& p : points) p.seen.x() = -p.seen.x();
    const auto poses = solve_planar_pose(points);
    ASSERT_FALSE(poses.has_value()) << "seed " << seed_ << " run " << run;
    EXPECT_EQ(poses.error().code, Errc::kPoseDegenerate);
  }
}

}  // namespace
}  // namespace ninedot
