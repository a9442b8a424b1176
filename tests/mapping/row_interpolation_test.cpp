// Landmarks before a camera that swings, seen by rows one after the other: a recording knows where they were
// afterwards.
#include "mapping/row_interpolation.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <numbers>
#include <vector>

#include "base/units.h"
#include "geometry/landmark.h"
#include "tests/support/random.h"

namespace ninedot {
namespace {

using test::Random;

const CameraModel kCamera{};
const LandmarkGeometry kSheet{};
constexpr double kRow_s = 33e-6, kPeriod_s = 0.03, kDotSigma_px = 0.02;
constexpr double kOld_1_s = 0.05, kAny_1_s = 1.5;

/// 30 degrees to and fro every two seconds: up to 94 degrees per second, which change by up to 296 in each.
CameraFromLandmark place_at(double time_s) {
  const double yaw = 30 * kRadPerDeg * std::sin(std::numbers::pi * time_s);
  const Eigen::Matrix3d turn = exp_so3({0, -yaw, 0});
  const CameraFromLandmark before{exp_so3({1.4, 0.3, -0.2}), {0, 1, 4}};
  return {turn * before.rotation, turn * before.translation_m};
}

Eigen::Vector2d ray_at(double time_s, std::size_t dot) {
  const Eigen::Vector2d on_sheet_m = kSheet.centre_m(dot);
  return (place_at(time_s) * Eigen::Vector3d(on_sheet_m.x(), 0, on_sheet_m.y())).hnormalized();
}

struct Swing {
  std::vector<LandmarkSighting> seen;
  std::vector<RowedSighting> moving;
  double start_s = 0;

  double time_s(std::size_t picture) const { return start_s + kPeriod_s * static_cast<double>(picture); }
  Eigen::Vector2d error(std::size_t picture, std::size_t dot) const {
    return seen[picture].dots[dot].ray - ray_at(time_s(picture), dot);
  }
};

struct SwingOptions {
  std::size_t pictures = 30;
  double noise = 1, row_s = kRow_s, start_s = 0;
  bool knows_motion = true;  ///< that of half a picture before, which is what a track knows; false: none
};

/// Each picture's rays are taken to its instant by the motion that is known.
Swing swing(const SwingOptions& options = {}) {
  Random random(7);
  Swing swing;
  swing.start_s = options.start_s;
  const double sigma = kDotSigma_px / kCamera.fx_px;
  for (std::size_t picture = 0; picture < options.pictures; ++picture) {
    const double time_s = swing.time_s(picture);
    const CameraFromLandmark T = place_at(time_s), T_before = place_at(time_s - kPeriod_s);
    SheetMotion motion{{0, 0, 0}, {0, 0, 0}, options.row_s, 239.5};
    if (options.knows_motion) {
      motion.rotation_rad_s = log_so3(T.rotation * T_before.rotation.transpose()) / kPeriod_s;
      motion.translation_m_s = (T.translation_m - T_before.translation_m) / kPeriod_s;
    }
    LandmarkSighting seen{3, T, {}};
    const auto as_taken = [&](std::size_t dot) {
      const Eigen::Vector2d on_sheet_m = kSheet.centre_m(dot);
      const Eigen::Vector3d p_m = T * Eigen::Vector3d(on_sheet_m.x(), 0, on_sheet_m.y());
      double since_s = 0;
      for (int i = 0; i < 4; ++i)
        since_s = motion.since_s(kCamera.pixel_from_normalised(ray_at(time_s + since_s, dot)).y());
      return Eigen::Vector2d(ray_at(time_s + since_s, dot) - since_s * motion.ray_velocity(p_m, T.translation_m) +
                             options.noise * sigma * Eigen::Vector2d(random.normal(), random.normal()));
    };
    for (std::size_t dot = 0; dot < kDotCount; ++dot)
      seen.dots[dot] = {as_taken(dot), Eigen::Matrix2d::Identity() / (sigma * sigma)};
    const Eigen::Vector2d middle = as_taken(kCentreDot);
    seen.T_camera_landmark.translation_m = T.translation_m.z() * middle.homogeneous();
    swing.seen.push_back(seen);
    // As uncertain as the speed is old; or as it may be.
    swing.moving.push_back({nullptr, MonoTime{} + std::chrono::nanoseconds(std::llround(1e9 * time_s)), motion,
                            (options.knows_motion ? kOld_1_s : kAny_1_s) * std::abs(options.row_s)});
  }
  for (std::size_t picture = 0; picture < options.pictures; ++picture)
    swing.moving[picture].seen = &swing.seen[picture];
  return swing;
}

double rms_px(const Swing& swing, std::size_t first, std::size_t count) {
  double sum = 0;
  for (std::size_t picture = first; picture < first + count; ++picture)
    for (std::size_t dot = 0; dot < kDotCount; ++dot) sum += swing.error(picture, dot).squaredNorm() / 2;
  return kCamera.fx_px * std::sqrt(sum / static_cast<double>(count * kDotCount));
}

TEST(RowInterpolation, KnowsWhereALandmarkWasByThePicturesBeforeAndAfter) {
  Swing swung = swing();
  const double before_px = rms_px(swung, 0, 30);
  ASSERT_GT(before_px, 0.25);
  interpolate_rows(swung.moving, kCamera);
  EXPECT_LT(rms_px(swung, 0, 30), 1.25 * kDotSigma_px) << "hardly more than the dots' own noise, of " << before_px;
  EXPECT_LT(rms_px(swung, 0, 1), 1.5 * kDotSigma_px) << "the first has two after it";
}

/// The rest of the error, of all of a sighting's dots together, in its own sigmas: the dots' noise is not in it.
TEST(RowInterpolation, SaysHowCertainItIs) {
  for (const double noise : {0.0, 1.0}) {
    Swing swung = swing({60, noise}), alike = swing({60, noise, 1e-12});
    interpolate_rows(swung.moving, kCamera);
    double squares = 0;
    for (std::size_t picture = 0; picture < 60; ++picture) {
      Eigen::Vector2d off = Eigen::Vector2d::Zero();
      for (std::size_t dot = 0; dot < kDotCount; ++dot)
        off += (swung.error(picture, dot) - alike.error(picture, dot)) / kDotCount;
      const double rows = kCamera.pixel_from_normalised(ray_at(swung.time_s(picture), kCentreDot)).y() - 239.5;
      ASSERT_LT(swung.moving[picture].per_row_rad, kOld_1_s * kRow_s) << picture;
      squares += off.squaredNorm() / 2 / std::pow(swung.moving[picture].per_row_rad * rows, 2) / 60;
    }
    EXPECT_GT(std::sqrt(squares), 0.3) << noise;
    EXPECT_LT(std::sqrt(squares), 1.3) << noise;
  }
}

TEST(RowInterpolation, TakesAStraightLineThroughTwoPictures) {
  Swing two = swing({2, 1, kRow_s, 0.4, false}), many = swing();
  const double before_px = rms_px(two, 0, 2);
  std::vector<RowedSighting> all = many.moving;  // by which it knows how much a line leaves
  for (LandmarkSighting& seen : two.seen) seen.id = 4;
  for (const RowedSighting& moving : two.moving) all.push_back(moving);
  interpolate_rows(all, kCamera);
  EXPECT_LT(rms_px(two, 0, 2), 0.25 * before_px);
  EXPECT_LT(all[30].per_row_rad, 0.1 * kAny_1_s * kRow_s);
  EXPECT_GT(all[30].per_row_rad, 5 * all[10].per_row_rad) << "less certain than through three";
}

TEST(RowInterpolation, LeavesWhatItKnowsNoBetter) {
  const auto rays_of = [](const Swing& swung) {
    std::vector<Eigen::Vector2d> rays;
    for (const LandmarkSighting& seen : swung.seen)
      for (const DotSighting& dot : seen.dots) rays.push_back(dot.ray);
    return rays;
  };
  Swing one = swing({1}), global = swing({20, 1, 0.0}), certain = swing({20});
  for (RowedSighting& moving : certain.moving) moving.per_row_rad = 1e-12;
  for (Swing* swung : {&one, &global, &certain}) {
    const auto before = rays_of(*swung);
    interpolate_rows(swung->moving, kCamera);
    EXPECT_EQ(rays_of(*swung), before);
  }
  EXPECT_EQ(one.moving[0].per_row_rad, kOld_1_s * kRow_s);
}

/// A landmark that bears another one's id in one picture.
TEST(RowInterpolation, IsNotLedAstrayByAPictureThatShowsAnotherLandmark) {
  Swing swung = swing();
  for (DotSighting& dot : swung.seen[15].dots) dot.ray.x() += 0.2;
  swung.seen[15].T_camera_landmark.translation_m.x() += 0.2 * 4;
  interpolate_rows(swung.moving, kCamera);
  EXPECT_LT(rms_px(swung, 0, 15), 1.5 * kDotSigma_px);
  EXPECT_LT(rms_px(swung, 16, 14), 1.5 * kDotSigma_px);
}

}  // namespace
}  // namespace ninedot
