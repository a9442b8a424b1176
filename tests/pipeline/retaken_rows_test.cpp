// A rolling shutter's rows, taken to the middle one with one motion, and put right by another.
#include "pipeline/retaken_rows.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "pose/mirror_image.h"
#include "world/sighting_fit.h"

namespace ninedot {
namespace {

const CameraModel kCamera{};
const LandmarkGeometry kSheet{};

/// As rows one after the other show a moving sheet, each dot taken to the middle row with a motion.
PoseCandidate fitted_with(const CameraFromLandmark& T, const SheetMotion& motion, const SheetMotion& taken) {
  PoseCandidate candidate;
  candidate.pose.T_landmark_camera = T.inverse();
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d on_sheet_m = kSheet.centre_m(dot);
    const Eigen::Vector3d p_m = T * Eigen::Vector3d(on_sheet_m.x(), 0, on_sheet_m.y());
    const double since_s = taken.since_s(kCamera.pixel_from_normalised(p_m.hnormalized()).y());
    candidate.dots[dot].ray = p_m.hnormalized() + since_s * (motion.ray_velocity(p_m, T.translation_m) -
                                                             taken.ray_velocity(p_m, T.translation_m));
    candidate.dots[dot].information = 1e8 * Eigen::Matrix2d::Identity();
  }
  return candidate;
}

/// Gauss and Newton's, as a solver would.
void fit_to_dots(PoseCandidate& candidate) {
  auto& T_landmark_camera = candidate.pose.T_landmark_camera;
  const LandmarkSighting seen{0, T_landmark_camera.inverse(), candidate.dots};
  for (int round = 0; round < 5; ++round) {
    const WorldFromCamera at{T_landmark_camera.rotation, T_landmark_camera.translation_m};
    const SightingFit fit = fit_of_sighting(seen, {}, at, kSheet);
    const WorldFromCamera next = moved_by(at, -fit.normal.llt().solve(fit.gradient));
    T_landmark_camera = {next.rotation, next.translation_m};
  }
}

TEST(RetakenRows, AreWhereTheTrueMotionHasThem) {
  const CameraFromLandmark T{exp_so3({1.4, 0.3, -0.2}), {0.3, 0.55, 2.5}};
  SheetMotion taken{{0, 0, 0}, {0.2, 0, 0}, 33e-6, 239.5}, motion = taken;
  motion.translation_m_s = {0.5, -0.1, 0.05};
  PoseCandidate fitted = fitted_with(T, motion, taken);
  fit_to_dots(fitted);
  ASSERT_GT((fitted.pose.T_landmark_camera.inverse().translation_m - T.translation_m).norm(), 0.0015);

  retake_rows(fitted, taken, motion, kSheet, kCamera);
  const PoseCandidate expected = fitted_with(T, motion, motion);
  for (std::size_t dot = 0; dot < kDotCount; ++dot)
    EXPECT_LT((fitted.dots[dot].ray - expected.dots[dot].ray).norm(), 2e-6) << dot;  // of 8e-4
  const CameraFromLandmark now = fitted.pose.T_landmark_camera.inverse();
  EXPECT_LT((now.translation_m - T.translation_m).norm(), 0.0006);
  EXPECT_LT(angle_between_rad(now, T), 0.0005);
}

TEST(RetakenRows, OfAGlobalShutterStayWhereTheyAre) {
  const CameraFromLandmark T{exp_so3({1.4, 0.3, -0.2}), {0.3, 0.55, 2.5}};
  const SheetMotion taken{{0, 0, 0}, {0.2, 0, 0}, 0, 239.5}, motion{{0, 0, 0}, {1.7, 0, 0}, 0, 239.5};
  PoseCandidate fitted = fitted_with(T, motion, taken);
  retake_rows(fitted, taken, motion, kSheet, kCamera);
  EXPECT_EQ(fitted.pose.T_landmark_camera.translation_m, T.inverse().translation_m);
}

}  // namespace
}  // namespace ninedot
