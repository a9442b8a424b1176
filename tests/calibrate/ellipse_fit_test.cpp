// The founding paper's constants from made-up shots: rings drawn by the paper's own equations come back with the
// constants that they were drawn with, and true perspective comes out with its distances.
#include "calibrate/ellipse_fit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/startup_error.h"
#include "pose/ellipse_distance.h"
#include "tests/support/random.h"

namespace ninedot {
namespace {

constexpr double kFocal_mm = 5.4, kFx_px = 720;
constexpr double kDistances_m[] = {0.6, 0.8, 1.1, 1.5, 2.0, 2.7, 3.6};

/// A frontal ring of this semi-axis, P9 at this place [px].
EllipseShot ring_shot(std::uint64_t frame, double distance_m, double radius_px, const Eigen::Vector2d& p9_px,
                      const Eigen::Vector2d& stretch = {1, 1}) {
  EllipseShot shot;
  shot.frame = frame, shot.distance_m = distance_m;
  shot.sight.seen.fill(true);
  const LandmarkGeometry landmark{};
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d at = landmark.centre_m(dot) / landmark.ring_radius_m * radius_px;
    shot.sight.outline_centres[dot] = (p9_px + Eigen::Vector2d(-at.x() / stretch.x(), -at.y() / stretch.y())) / kFx_px;
  }
  return shot;
}

/// Rings as large as (8) and (9) have them.
std::vector<EllipseShot> shots_by(const EllipseCalibration& c) {
  const double f_mm = kFx_px * c.kmm_mm_per_px;
  std::vector<EllipseShot> shots;
  for (const double distance_m : kDistances_m) {
    const double image_mm = 1000 * distance_m + f_mm;
    const double F = c.p1 + c.p2 * std::pow(image_mm, c.p3);
    shots.push_back(ring_shot(shots.size(), distance_m, f_mm * 80 / (F * 1000 * distance_m), {3, -5}));
  }
  return shots;
}

std::string refusal(const std::vector<EllipseShot>& shots) {
  try {
    fit_ellipse_calibration(shots, CameraModel{}, {}, kFocal_mm);
  } catch (const StartupError& error) {
    EXPECT_EQ(error.status, ExitStatus::kWorkFailed);
    return error.what();
  }
  return "no refusal";
}

TEST(EllipseFit, FindsTheConstantsThatTheShotsWereMadeWith) {
  const double K = kFocal_mm / kFx_px;
  for (const double p3 : {-2.0, -1.0, 0.5}) {
    // F is K in the mean (7) to first order; what the fit is held to is F at each distance.
    const double p2 = 0.02 * K / std::pow(1000, p3);
    const EllipseCalibration made{K, K * 0.99, p2, p3, 0, 0};
    const EllipseFit fit = fit_ellipse_calibration(shots_by(made), CameraModel{}, {}, kFocal_mm);
    EXPECT_TRUE(fit.depends_on_distance);
    EXPECT_NEAR(fit.calibration.p3, p3, 0.02) << "f is fx Kmm, which differs by a hundredth";
    EXPECT_LT(fit.worst_share, 1e-5);
    EXPECT_EQ(fit.centred, std::size(kDistances_m));
    // The solver's distances at others than the shots' are those of the shots' law.
    const EllipseCalibration& c = fit.calibration;
    for (const double distance_mm : {700.0, 1300.0, 3000.0}) {
      const double f_mm = kFx_px * K;
      const double radius_px = f_mm * 80 / ((made.p1 + made.p2 * std::pow(distance_mm + f_mm, p3)) * distance_mm);
      const double f_fit_mm = kFx_px * c.kmm_mm_per_px;
      const auto image_mm = image_distance_mm(radius_px, 80, {f_fit_mm, c.kmm_mm_per_px, c.p1, c.p2, c.p3});
      ASSERT_TRUE(image_mm);
      EXPECT_NEAR(*image_mm - f_fit_mm, distance_mm, 1e-4 * distance_mm);
    }
  }
}

TEST(EllipseFit, FindsOneFactorWhereTheDistanceChangesNothing) {
  const double K = kFocal_mm / kFx_px;
  const std::vector<EllipseShot> shots = shots_by({K, K, 0, 1, 0, 0});
  const EllipseFit exact = fit_ellipse_calibration(shots, CameraModel{}, {}, kFocal_mm);
  EXPECT_NEAR(exact.calibration.kmm_mm_per_px, K, 1e-9);
  EXPECT_NEAR(exact.calibration.p1, K, 1e-9);

  // Noise is no law, but for one time in a hundred, and what it does to the larger one of two equal axes, which is
  // larger where the ring is small.
  constexpr int kTimes = 300;
  int laws = 0;
  double sum = 0;
  for (std::uint64_t seed = 0; seed < kTimes; ++seed) {
    test::Random random(seed);
    std::vector<EllipseShot> noisy = shots;
    for (EllipseShot& shot : noisy)
      for (Eigen::Vector2d& centre : shot.sight.outline_centres)
        for (double& axis : centre) axis += 0.05 / kFx_px * random.normal();
    const EllipseFit fit = fit_ellipse_calibration(noisy, CameraModel{}, {}, kFocal_mm);
    EXPECT_LT(fit.worst_share, 0.01) << seed;
    if (fit.depends_on_distance) {
      ++laws;
      continue;
    }
    EXPECT_EQ(fit.calibration.p2, 0);
    EXPECT_NEAR(fit.calibration.p1, K, 0.005 * K) << seed;
    sum += fit.calibration.p1 / K - 1;
  }
  EXPECT_LE(laws, 0.07 * kTimes);
  EXPECT_NEAR(sum / (kTimes - laws), 0, 0.002);
}

TEST(EllipseFit, FindsTheOffCentreCorrectionByItsEquation) {
  const double K = kFocal_mm / kFx_px, cu = 4e-12, cv = 9e-12;
  std::vector<EllipseShot> shots = shots_by({K, K, 0, 1, 0, 0});
  for (EllipseShot& shot : shots)
    shot = ring_shot(shot.frame, shot.distance_m, kFx_px * 0.08 / shot.distance_m, {0, 0});
  const auto stretch = [&](double u, double v) {
    return Eigen::Vector2d(1 + cu * (u * u + u * u * u * u), 1 + cv * (v * v + v * v * v * v));
  };
  std::uint64_t frame = 100;
  for (const Eigen::Vector2d& p9_px : {Eigen::Vector2d(200, 0), Eigen::Vector2d(-150, 120), Eigen::Vector2d(0, -150)}) {
    shots.push_back(ring_shot(frame++, 1.5, kFx_px * 0.08 / 1.5, p9_px, stretch(p9_px.x(), p9_px.y())));
    shots.back().centred_frame = 3;
  }
  const EllipseFit fit = fit_ellipse_calibration(shots, CameraModel{}, {}, kFocal_mm);
  EXPECT_NEAR(fit.calibration.cu, cu, 1e-6 * cu);
  EXPECT_NEAR(fit.calibration.cv, cv, 1e-6 * cv);
  EXPECT_EQ(fit.off_centre, 3U);
  shots.pop_back();
  shots.erase(shots.end() - 1);  // what is left is off along u alone
  EXPECT_EQ(fit_ellipse_calibration(shots, CameraModel{}, {}, kFocal_mm).calibration.cv, 0);
}

TEST(EllipseFit, RefusesShotsThatDoNotSufficeOrContradict) {
  const double K = kFocal_mm / kFx_px;
  const std::vector<EllipseShot> good = shots_by({K, K, 0, 1, 0, 0});
  EXPECT_EQ(refusal({}).substr(0, 38), "there are centred shots at 0 distances");
  EXPECT_EQ(refusal({good[0], good[1], good[2], good[2]}).substr(0, 38), "there are centred shots at 3 distances");
  std::vector<EllipseShot> shots = good;
  std::swap(shots[1].distance_m, shots[4].distance_m);
  EXPECT_EQ(
      refusal(shots),
      "frame 2 is said to be at 1100 mm, but shows a larger ring than frame 4 at 800 mm: are the distances in the "
      "order of the frames?");
  shots = good;
  shots[4].distance_m = 2.3;
  EXPECT_EQ(
      refusal(shots),
      "frame 4 is said to be at 2300 mm, but by the other shots it is at about 2000 mm: measure again, from P9 to "
      "the lens");
  shots = good;
  shots[2].sight.seen[4] = false;
  EXPECT_EQ(refusal(shots), "frame 2: P5 is hidden; a shot for a calibration shows all nine dots");
  shots = good;
  shots[2] = ring_shot(2, 1.1, 52, {100, 0});
  EXPECT_EQ(
      refusal(shots),
      "frame 2: P9 is 100 px from the optical axis, which is too far for a centred shot: bring it within 32 px, or "
      "say of which centred frame it is the off-centre shot");
  shots = good;
  shots.push_back(ring_shot(9, 1.5, 38.4, {10, 0}));
  shots.back().centred_frame = 3;
  EXPECT_EQ(refusal(shots).substr(0, 41), "frame 9: P9 is 10 px from the optical axi");
  shots.back() = ring_shot(9, 1.5, 38.4, {100, 0});
  shots.back().centred_frame = 2;
  EXPECT_EQ(refusal(shots), "frame 9 at 1500 mm and its centred frame 2 at 1100 mm: both are taken from one place");
  shots.back().centred_frame = 55;
  EXPECT_EQ(refusal(shots), "frame 9: its centred frame 55 is not among the centred shots");
}

}  // namespace
}  // namespace ninedot
