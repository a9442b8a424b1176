#include "pose/ellipse_solver.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "pose/ellipse_parameters.h"
#include "tests/pose/ellipse_scene.h"
#include "tests/support/best_pose.h"

namespace ninedot {
namespace {

using namespace ellipse_scene;

const CameraModel kCamera;      // 640x480, f = 720 px
const LandmarkGeometry kSheet;  // R = 80 mm

/// Every distance, tilt, pan quadrant and roll, off the picture's middle by `yaw` and `pitch`.
template <typename Check>
void over_all_views(double yaw_deg, double pitch_deg, const Check& check) {
  for (const double distance_m : {0.3, 0.5, 1.0, 2.0, 4.4, 7.0})
    for (const double tilt_deg : {1.0, 5.0, 20.0, 45.0, 60.0, 75.0})
      for (double azimuth_deg = -180; azimuth_deg < 180; azimuth_deg += 22.5)
        for (const double roll_deg : {0.0, 37.0, -80.0, 150.0}) {
          const View view{distance_m, tilt_deg, azimuth_deg, roll_deg, yaw_deg, pitch_deg};
          SCOPED_TRACE(testing::Message() << distance_m << " m, tilt " << tilt_deg << ", azimuth " << azimuth_deg
                                          << ", roll " << roll_deg);
          check(view);
          if (testing::Test::HasFatalFailure()) return;
        }
}

void expect_exact(std::initializer_list<int> hidden, int level, int dots) {
  const EllipseSolver solver(kCamera, kSheet, {});
  over_all_views(5, 4, [&](const View& view) {
    const CameraInLandmark truth = view.pose();
    const auto found = test::best_pose(solver.solve(hide(see(kCamera, kSheet, truth), hidden)));
    ASSERT_TRUE(found.has_value()) << found.error().text;
    ASSERT_LT(position_error_m(found->T_landmark_camera, truth), 1e-6 * view.distance_m);
    ASSERT_LT(rotation_error_rad(found->T_landmark_camera, truth), 1e-6);
    ASSERT_LT(found->rms_px, 1e-5);
    ASSERT_EQ(found->occlusion_level, level);
    ASSERT_EQ(found->dots_used, dots);
  });
}

TEST(EllipseSolver, IsExactWhereNothingIsHidden) { expect_exact({}, 0, 9); }
TEST(EllipseSolver, IsExactAtLevelIWithOneRingDotMissing) { expect_exact({1}, 1, 8); }
TEST(EllipseSolver, IsExactAtLevelIWithTwoRingDotsMissing) { expect_exact({3, 4}, 1, 7); }
TEST(EllipseSolver, IsExactAtLevelIIFromTheCentreDotAndFiveRingDots) { expect_exact({1, 2, 3}, 2, 6); }
TEST(EllipseSolver, IsExactAtLevelIIFromTheCentreDotAndOneRingDot) { expect_exact({1, 2, 3, 4, 5, 6, 7}, 2, 2); }
TEST(EllipseSolver, IsExactAtLevelIIIFromTheRingAlone) { expect_exact({9}, 3, 8); }
TEST(EllipseSolver, IsExactAtLevelIIIFromFiveNeighbouringRingDots) { expect_exact({9, 1, 2, 3}, 3, 5); }

TEST(EllipseSolver, FrontalViewsKeepDistanceAndDirection) {
  const EllipseSolver solver(kCamera, kSheet, {});
  for (const double distance_m : {0.3, 1.0, 7.0}) {
    const CameraInLandmark truth = View{distance_m, 0, 0, 30, 12, 9}.pose();
    const auto found = test::best_pose(solver.solve(see(kCamera, kSheet, truth)));
    ASSERT_TRUE(found.has_value());
    EXPECT_NEAR(found->ellipse.distance_m / distance_m, 1, 1e-4);
    EXPECT_LT(rotation_error_rad(found->T_landmark_camera, truth), 0.25 * kRad);  // acos(b / a) has a root there
  }
}

TEST(EllipseSolver, ReportsTheParametersThatTheTruePoseHas) {
  const EllipseSolver solver(kCamera, kSheet, {});
  over_all_views(8, -6, [&](const View& view) {
    const auto found = test::best_pose(solver.solve(see(kCamera, kSheet, view.pose())));
    ASSERT_TRUE(found.has_value());
    const EllipseParameters truth = ellipse_parameters(view.pose(), kCamera, kSheet);
    ASSERT_NEAR(found->ellipse.distance_m, truth.distance_m, 1e-7);
    ASSERT_NEAR(found->ellipse.image_distance_m, truth.image_distance_m, 1e-7);
    ASSERT_NEAR(found->ellipse.tilt_phi_rad, truth.tilt_phi_rad, 1e-6);
    ASSERT_NEAR(std::remainder(found->ellipse.pan_theta_rad - truth.pan_theta_rad, 2 * M_PI), 0, 1e-5);
    ASSERT_NEAR(std::remainder(found->ellipse.swing_psi_rad - truth.swing_psi_rad, M_PI), 0, 1e-5);
    ASSERT_NEAR(found->ellipse.deviation_rad, truth.deviation_rad, 1e-7);
  });
}

TEST(EllipseSolver, RotatingThePictureRotatesThePoseAboutTheOpticalAxis) {
  CameraModel camera = kCamera;
  camera.cx_px = camera.cy_px = 0;
  const EllipseSolver solver(camera, kSheet, {});
  auto random = random_for("RotatingThePictureRotatesThePoseAboutTheOpticalAxis");
  const LandmarkObservation seen = add_noise(see(camera, kSheet, View{1, 40, 70, 10, 5, 5}.pose()), 0.05, random);
  const auto before = test::best_pose(solver.solve(seen));
  ASSERT_TRUE(before.has_value());
  for (const double turn_rad : {0.4, 1.6, -2.5}) {
    LandmarkObservation turned = seen;
    for (DotObservation& dot : turned.dots) dot.centroid_px = Eigen::Rotation2Dd(turn_rad) * dot.centroid_px;
    const auto after = test::best_pose(solver.solve(turned));
    ASSERT_TRUE(after.has_value());
    EXPECT_LT(position_error_m(after->T_landmark_camera, before->T_landmark_camera), 1e-8);
    EXPECT_LT(
        (after->T_landmark_camera.rotation * exp_so3({0, 0, turn_rad}) - before->T_landmark_camera.rotation).norm(),
        1e-7);
  }
}

TEST(EllipseSolver, LensDistortionIsRemovedFirst) {
  CameraModel lens = kCamera;
  lens.k = {-0.28, 0.11, 0.0008, -0.0005, -0.02};
  const EllipseSolver solver(lens, kSheet, {});
  const CameraInLandmark truth = View{0.8, 35, 50, 5, 9, 6}.pose();
  for (const std::initializer_list<int>& hidden : {std::initializer_list<int>{}, {1, 2, 3}}) {
    LandmarkObservation seen = hide(see(kCamera, kSheet, truth), hidden);
    for (DotObservation& dot : seen.dots) {
      if (!dot.seen) continue;
      const Eigen::Vector2d ideal((dot.centroid_px.x() - kCamera.cx_px) / kCamera.fx_px,
                                  (dot.centroid_px.y() - kCamera.cy_px) / kCamera.fy_px);
      Eigen::Matrix2d J;
      dot.centroid_px = lens.pixel_from_normalised(ideal, &J);
      J /= kCamera.fx_px;
      const Eigen::Matrix2d turn = Eigen::Rotation2Dd(dot.angle_rad).toRotationMatrix();
      const Eigen::Matrix2d axes = J * turn * Eigen::Vector2d(dot.semi_major_px, dot.semi_minor_px).asDiagonal();
      const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(axes * axes.transpose());
      dot.semi_minor_px = std::sqrt(eigen.eigenvalues()(0));
      dot.semi_major_px = std::sqrt(eigen.eigenvalues()(1));
      dot.angle_rad = std::atan(eigen.eigenvectors()(1, 1) / eigen.eigenvectors()(0, 1));
    }
    const auto found = test::best_pose(solver.solve(seen));
    ASSERT_TRUE(found.has_value()) << found.error().text;
    const double tolerance = hidden.size() == 0 ? 1e-7 : 0.005;  // an ellipse is no longer quite one behind a lens
    EXPECT_LT(position_error_m(found->T_landmark_camera, truth), tolerance * 0.8);
  }
}

// With the paper's own calibration its formulas are taken literally; what they leave out is what they err by.
TEST(EllipseSolver, LiteralDistanceErrsByHalfTheSquareOfRSinPhiOverD) {
  EllipseCalibration paper;
  paper.kmm_mm_per_px = 0.0075;
  const EllipseSolver solver(kCamera, kSheet, paper);
  over_all_views(0, 0, [&](const View& view) {
    const CameraInLandmark truth = view.pose();
    const auto found = test::best_pose(solver.solve(see(kCamera, kSheet, truth)));
    ASSERT_TRUE(found.has_value());
    const double share = kSheet.ring_radius_m * std::sin(view.tilt_deg * kRad) / view.distance_m;
    ASSERT_NEAR(1 - found->ellipse.distance_m / view.distance_m, share * share / 2, 0.08 * share * share + 1e-6);
    ASSERT_LT(rotation_error_rad(found->T_landmark_camera, truth),
              0.3 * kSheet.ring_radius_m * kSheet.ring_radius_m / (view.distance_m * view.distance_m));
    ASSERT_NEAR(found->ellipse.image_distance_m, found->ellipse.distance_m + 0.0054, 1e-12);  // D' = D + f (4)
  });
}

TEST(EllipseSolver, LiteralMethodHandlesTheOcclusionLevels) {
  EllipseCalibration paper;
  paper.kmm_mm_per_px = 0.0075;
  const EllipseSolver solver(kCamera, kSheet, paper);
  const CameraInLandmark truth = View{0.9, 40, -130, 20}.pose();  // the paper's own test stood at 90 cm
  int level = 0;
  for (const std::initializer_list<int>& hidden : {std::initializer_list<int>{}, {2, 5}, {1, 2, 3, 4}, {9, 1}}) {
    const auto found = test::best_pose(solver.solve(hide(see(kCamera, kSheet, truth), hidden)));
    ASSERT_TRUE(found.has_value()) << found.error().text;
    EXPECT_EQ(found->occlusion_level, level++);
    EXPECT_LT(position_error_m(found->T_landmark_camera, truth), 0.01);  // the paper: about 1 cm
  }
}

TEST(EllipseSolver, RefinedScaleOfEquation8ChangesTheDistance) {
  EllipseCalibration refined;
  refined.kmm_mm_per_px = 0.0075;
  refined.p1 = 0.0075 * 1.02;
  const CameraInLandmark truth = View{2, 10, 30}.pose();
  const auto found = test::best_pose(EllipseSolver(kCamera, kSheet, refined).solve(see(kCamera, kSheet, truth)));
  ASSERT_TRUE(found.has_value());
  EXPECT_NEAR(found->ellipse.distance_m, 2 / 1.02, 1e-3);

  refined.p2 = -1;
  refined.p3 = 1;
  const auto refused = test::best_pose(EllipseSolver(kCamera, kSheet, refined).solve(see(kCamera, kSheet, truth)));
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().code, Errc::kPoseDegenerate);
}

TEST(EllipseSolver, OffCentreCoefficientsUndoTheStretchAwayFromTheMiddle) {
  // Turned aside by delta, the picture is stretched by 1 / cos^2(delta) along the offset: 1 + cu u9^2 + cu u9^4 =
  // cos^2(delta).
  const double delta_rad = 12 * kRad, u9_px = 720 * std::tan(delta_rad);
  EllipseCalibration plain, corrected;
  plain.kmm_mm_per_px = corrected.kmm_mm_per_px = 0.0075;
  corrected.cu = (std::pow(std::cos(delta_rad), 2) - 1) / (std::pow(u9_px, 2) + std::pow(u9_px, 4));
  const CameraInLandmark truth = View{2, 40, 90, 0, 12, 0}.pose();  // from above: the major axis lies along the offset
  const LandmarkObservation seen = see(kCamera, kSheet, truth);
  const auto before = test::best_pose(EllipseSolver(kCamera, kSheet, plain).solve(seen));
  const auto after = test::best_pose(EllipseSolver(kCamera, kSheet, corrected).solve(seen));
  ASSERT_TRUE(before.has_value() && after.has_value());
  EXPECT_GT(std::abs(before->ellipse.distance_m - 2), 0.07);
  EXPECT_LT(std::abs(after->ellipse.distance_m - 2), 0.005);
}

TEST(EllipseSolver, CovarianceAgreesWithTheErrorsMade) {
  const EllipseSolver solver(kCamera, kSheet, {});
  auto random = random_for("CovarianceAgreesWithTheErrorsMade");
  std::uniform_real_distribution<double> circle(-180, 180);
  for (const std::initializer_list<int>& hidden :
       {std::initializer_list<int>{}, {1, 4}, {1, 2, 3, 5}, {9}, {9, 1, 2}}) {
    double sum = 0;
    constexpr int kRuns = 400;
    for (int run = 0; run < kRuns; ++run) {
      const CameraInLandmark truth = View{0.5, run % 2 == 0 ? 30.0 : 60.0, circle(random), circle(random), 5, 4}.pose();
      const auto found =
          test::best_pose(solver.solve(add_noise(hide(see(kCamera, kSheet, truth), hidden), 0.1, random)));
      ASSERT_TRUE(found.has_value());
      Vector6d error;
      error << truth.translation_m - found->T_landmark_camera.translation_m,
          log_so3(found->T_landmark_camera.rotation.transpose() * truth.rotation);
      sum += error.dot(found->covariance.ldlt().solve(error));
    }
    EXPECT_GT(sum / kRuns, 4) << hidden.size() << " hidden";  // six freedoms
    EXPECT_LT(sum / kRuns, 9) << hidden.size() << " hidden";
  }
}

TEST(EllipseSolver, CovarianceGrowsWithTheResidual) {
  const EllipseSolver solver(kCamera, kSheet, {});
  auto random = random_for("CovarianceGrowsWithTheResidual");
  const LandmarkObservation seen = see(kCamera, kSheet, View{1, 40, 30}.pose());
  const auto good = test::best_pose(solver.solve(add_noise(seen, 0.02, random)));
  const auto bad = test::best_pose(solver.solve(add_noise(seen, 1, random)));
  ASSERT_TRUE(good.has_value() && bad.has_value());
  EXPECT_GT(bad->covariance.trace(), 10 * good->covariance.trace());
  EXPECT_GT(good->covariance.diagonal().minCoeff(), 0);
}

TEST(EllipseSolver, AmbiguityGrowsWithDistance) {
  const EllipseSolver solver(kCamera, kSheet, {});
  const auto near = test::best_pose(solver.solve(see(kCamera, kSheet, View{0.5, 40, 30}.pose())));
  const auto far = test::best_pose(solver.solve(see(kCamera, kSheet, View{7, 40, 30}.pose())));
  const auto frontal = test::best_pose(solver.solve(see(kCamera, kSheet, View{5, 0.05, 30}.pose())));
  ASSERT_TRUE(near.has_value() && far.has_value() && frontal.has_value());
  EXPECT_LT(near->ambiguity, 1e-3);
  EXPECT_GT(far->ambiguity, 30 * near->ambiguity);
  EXPECT_GT(frontal->ambiguity, 0.95);
}

void expect_degenerate(const LandmarkObservation& seen) {
  const auto found = test::best_pose(EllipseSolver(kCamera, kSheet, {}).solve(seen));
  ASSERT_FALSE(found.has_value());
  EXPECT_EQ(found.error().code, Errc::kPoseDegenerate);
}

TEST(EllipseSolver, RefusesWhatDoesNotDetermineAPose) {
  const LandmarkObservation seen = see(kCamera, kSheet, View{1, 40, 30}.pose());
  expect_degenerate({});
  expect_degenerate(hide(seen, {1, 2, 3, 4, 5, 6, 7, 8}));  // P9 alone
  expect_degenerate(hide(seen, {9, 1, 2, 3, 4}));           // four ring dots
  LandmarkObservation no_outline = hide(seen, {1, 2, 3});
  no_outline.dots[kCentreDot].semi_minor_px = 0;
  expect_degenerate(no_outline);
  LandmarkObservation line = seen;
  for (DotObservation& dot : line.dots) dot.centroid_px.y() = 200;
  expect_degenerate(line);
}

TEST(EllipseSolver, RefusesDotsOutsideTheLensesField) {
  CameraModel lens = kCamera;
  lens.k = {-2.0, 0, 0, 0, 0};  // turns back at 190 px from the middle
  const auto found =
      test::best_pose(EllipseSolver(lens, kSheet, {}).solve(see(kCamera, kSheet, View{0.3, 10, 30, 0, 14}.pose())));
  ASSERT_FALSE(found.has_value());
  EXPECT_EQ(found.error().code, Errc::kPoseDegenerate);
}

}  // namespace
}  // namespace ninedot
