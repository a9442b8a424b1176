#include "world/sighting_fit.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <cmath>
#include <limits>

namespace ninedot {
namespace {

const LandmarkGeometry kLandmark{};
const WorldFromLandmark kPlace{exp_so3({0, 0, 0.7}), {1.2, -0.4, 1.5}};

/// Two metres in front of the sheet and a little aside.
WorldFromCamera usual_place() {
  Eigen::Matrix3d R_landmark_camera;  // looks along -Y of the sheet, its x to the sheet's -X
  R_landmark_camera << -1, 0, 0, 0, 0, -1, 0, -1, 0;
  return {kPlace.rotation * R_landmark_camera * exp_so3({0.1, -0.15, 0.2}), kPlace * Eigen::Vector3d(0.2, 2.0, -0.1)};
}

LandmarkSighting sighting_from(const WorldFromCamera& T_world_camera) {
  LandmarkSighting sighting;
  sighting.T_camera_landmark = T_world_camera.inverse() * kPlace;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d on_sheet_m = kLandmark.centre_m(dot);
    sighting.dots[dot].ray =
        (sighting.T_camera_landmark * Eigen::Vector3d(on_sheet_m.x(), 0, on_sheet_m.y())).hnormalized();
    sighting.dots[dot].information << 4e6 + 1e5 * static_cast<double>(dot), 3e5, 3e5, 3e6;
  }
  return sighting;
}

PoseStep any_step(double size) {
  PoseStep step;
  step << 0.3, -0.2, 0.5, -0.1, 0.2, 0.15;
  return size * step;
}

TEST(SightingFit, IsPerfectWhereTheSightingIsFrom) {
  const SightingFit fit = fit_of_sighting(sighting_from(usual_place()), kPlace, usual_place(), kLandmark);
  EXPECT_EQ(fit.dots, 9);
  EXPECT_LT(fit.chi2, 1e-15);
  EXPECT_LT(fit.gradient.norm(), 1e-6);
}

TEST(SightingFit, GradientIsHalfTheSlopeOfChi2) {
  const LandmarkSighting sighting = sighting_from(usual_place());
  const WorldFromCamera at = moved_by(usual_place(), any_step(0.05));
  const SightingFit fit = fit_of_sighting(sighting, kPlace, at, kLandmark);
  for (Eigen::Index i = 0; i < 6; ++i) {
    const PoseStep step = 1e-6 * PoseStep::Unit(i);
    const double slope = (fit_of_sighting(sighting, kPlace, moved_by(at, step), kLandmark).chi2 -
                          fit_of_sighting(sighting, kPlace, moved_by(at, -step), kLandmark).chi2) /
                         2e-6;
    EXPECT_NEAR(fit.gradient(i), slope / 2, 1e-5 * fit.gradient.norm()) << i;
  }
}

TEST(SightingFit, StepsOfItsEquationsLeadToTheCamera) {
  const LandmarkSighting sighting = sighting_from(usual_place());
  WorldFromCamera at = moved_by(usual_place(), any_step(0.2));
  for (int i = 0; i < 6; ++i) {
    const SightingFit fit = fit_of_sighting(sighting, kPlace, at, kLandmark);
    at = moved_by(at, -fit.normal.ldlt().solve(fit.gradient));
  }
  EXPECT_LT(step_between(at, usual_place()).norm(), 1e-9);
}

TEST(SightingFit, LeavesOutDotsThatAreNotSeen) {
  LandmarkSighting sighting = sighting_from(usual_place());
  sighting.dots[3] = {};
  sighting.dots[8] = {};
  const SightingFit fit = fit_of_sighting(sighting, kPlace, moved_by(usual_place(), any_step(1e-3)), kLandmark);
  EXPECT_EQ(fit.dots, 7);
  LandmarkSighting same = sighting;
  same.dots[3].ray = {100, 100};
  EXPECT_EQ(fit_of_sighting(same, kPlace, moved_by(usual_place(), any_step(1e-3)), kLandmark).chi2, fit.chi2);
}

/// A turn that nobody knows of takes what all rays have alike, and nothing of where they lie about each other.
TEST(SightingFit, ItsOwnTurnTakesTheDirectionAndLeavesTheDistance) {
  LandmarkSighting sighting = sighting_from(usual_place());
  const WorldFromCamera at = moved_by(usual_place(), any_step(1e-3));
  const SightingFit sharp = fit_of_sighting(sighting, kPlace, at, kLandmark);
  const double ray_sigma = 1 / std::sqrt(9 * 3e6);
  sighting.turn_sigma_rad = 30 * ray_sigma;
  const SightingFit turned = fit_of_sighting(sighting, kPlace, at, kLandmark);
  const Eigen::Vector3d sight = (kPlace.translation_m - usual_place().translation_m).normalized();
  const auto sigma_along = [&](const SightingFit& fit) {
    const PoseInformation covariance = fit.normal.inverse();
    return std::sqrt(sight.dot(covariance.topLeftCorner<3, 3>() * sight));
  };
  const auto turn_sigma = [](const SightingFit& fit) {
    return std::sqrt(fit.normal.inverse().bottomRightCorner<3, 3>().trace());
  };
  EXPECT_NEAR(sigma_along(turned) / sigma_along(sharp), 1, 0.01);
  // Alone the place and the direction go together: beside other landmarks it is the rotation that is left open.
  EXPECT_NEAR(std::pow(turn_sigma(turned), 2) - std::pow(turn_sigma(sharp), 2), 3 * std::pow(30 * ray_sigma, 2),
              0.01 * 3 * std::pow(30 * ray_sigma, 2));
  EXPECT_LT(turned.chi2, sharp.chi2);
  EXPECT_EQ(turned.dots, sharp.dots);
}

TEST(SightingFit, OfACameraThatLooksAwayIsInfinitelyBad) {
  WorldFromCamera away = usual_place();
  away.rotation = away.rotation * exp_so3({0, 3.0, 0});
  const SightingFit fit = fit_of_sighting(sighting_from(usual_place()), kPlace, away, kLandmark);
  EXPECT_EQ(fit.chi2, std::numeric_limits<double>::infinity());
  EXPECT_EQ(fit.normal.norm(), 0);
}

TEST(SightingFit, StepsAreWhatLiesBetweenTwoPlaces) {
  const WorldFromCamera from = usual_place(), to = moved_by(from, any_step(1));
  EXPECT_LT((step_between(from, to) - any_step(1)).norm(), 1e-12);
}

}  // namespace
}  // namespace ninedot
