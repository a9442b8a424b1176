// Landmarks of which the search of the whole picture sees little but P9.
#include "detect/close_look.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "detect/detector.h"
#include "detect/homography.h"
#include "tests/support/renderer.h"

namespace ninedot {
namespace {

constexpr int kWidth_px = 640, kHeight_px = 480;
constexpr std::uint8_t kWall = 205, kPaper = 220, kInk = 40;

ImageView view_of(const std::vector<std::uint8_t>& pixels) { return {pixels.data(), kWidth_px, kHeight_px, kWidth_px}; }

/// A sheet seen straight from in front, `px_per_m` large, with its P9 at (u, v); each pixel the mean of 8 x 8 places,
/// seen through a Gaussian, and dots paler than P9, as coloured ones are.
std::vector<std::uint8_t> sheet(double u, double v, double px_per_m, int dot_ink, double blur_px = 0.8) {
  const LandmarkGeometry landmark;
  const double paper_px = landmark.paper_radius_m() * px_per_m;
  std::vector<double> sharp;
  constexpr int kFine = 8;
  for (int y = 0; y < kHeight_px; ++y)
    for (int x = 0; x < kWidth_px; ++x) {
      if (std::max(std::abs(x - u), std::abs(y - v)) > paper_px + 1) {
        sharp.push_back(kWall);
        continue;
      }
      double sum = 0;
      for (int j = 0; j < kFine; ++j)
        for (int i = 0; i < kFine; ++i) {
          const Eigen::Vector2d at(x + (i + 0.5) / kFine - 0.5 - u, y + (j + 0.5) / kFine - 0.5 - v);
          double grey = at.cwiseAbs().maxCoeff() > paper_px ? kWall : kPaper;
          for (std::size_t dot = 0; dot < kDotCount; ++dot)
            if ((at - px_per_m * landmark.centre_m(dot)).norm() < px_per_m * landmark.radius_m(dot))
              grey = dot == kCentreDot ? kInk : dot_ink;
          sum += grey;
        }
      sharp.push_back(sum / (kFine * kFine));
    }
  std::vector<std::uint8_t> pixels;
  const auto at = [&](int x, int y) {
    return sharp[static_cast<std::size_t>(std::clamp(y, 0, kHeight_px - 1) * kWidth_px +
                                          std::clamp(x, 0, kWidth_px - 1))];
  };
  const int reach = static_cast<int>(std::ceil(3 * blur_px));
  std::vector<double> row(sharp.size());
  const auto blur = [&](const auto& from, int x, int y) {
    double sum = 0, weights = 0;
    for (int i = -reach; i <= reach; ++i) {
      const double weight = std::exp(-0.5 * i * i / (blur_px * blur_px));
      sum += weight * from(x, y, i), weights += weight;
    }
    return sum / weights;
  };
  for (int y = 0; y < kHeight_px; ++y)
    for (int x = 0; x < kWidth_px; ++x)
      row[static_cast<std::size_t>(y * kWidth_px + x)] = blur([&](int a, int b, int i) { return at(a + i, b); }, x, y);
  std::swap(sharp, row);
  for (int y = 0; y < kHeight_px; ++y)
    for (int x = 0; x < kWidth_px; ++x)
      pixels.push_back(
          static_cast<std::uint8_t>(std::lround(blur([&](int a, int b, int i) { return at(a, b + i); }, x, y))));
  return pixels;
}

/// As a search of the whole picture leaves P9.
Blob spot_at(double u, double v, double radius_px) {
  const auto variance_px2 = static_cast<float>(radius_px * radius_px / 4);
  return {static_cast<float>(u),
          static_cast<float>(v),
          static_cast<float>(std::numbers::pi * radius_px * radius_px),
          variance_px2,
          0,
          variance_px2,
          0};
}

constexpr double kDistant_px_per_m = 95;  // ring dots of 2.4 px

/// The guess that is right, with the blobs that are nearest to where its dots are.
Hypothesis true_guess(double u, double v, const BlobList& blobs) {
  const LandmarkGeometry landmark;
  Hypothesis guess;
  guess.H_px_plane << kDistant_px_per_m, 0, u, 0, kDistant_px_per_m, v, 0, 0, 1;
  guess.blob.fill(-1);
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d px = map_point(guess.H_px_plane, landmark.centre_m(dot));
    for (std::size_t i = 0; i < blobs.size(); ++i)
      if ((Eigen::Vector2d(blobs[i].x_px, blobs[i].y_px) - px).norm() < 1.5)
        guess.blob[dot] = static_cast<std::int16_t>(i), ++guess.matched;
  }
  return guess;
}

double squared_errors_px2(const Hypothesis& guess, const BlobList& blobs) {
  const LandmarkGeometry landmark;
  double sum = 0;
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    if (guess.blob[dot] < 0) continue;
    const Blob& blob = blobs[static_cast<std::size_t>(guess.blob[dot])];
    const Eigen::Vector2d px = map_point(guess.H_px_plane, landmark.centre_m(dot));
    sum += (Eigen::Vector2d(blob.x_px, blob.y_px) - px).squaredNorm();
  }
  return sum;
}

TEST(CloseLook, TakesForACentreWhatIsSmallAndInkOnPaper) {
  const CloseLook unit{LandmarkGeometry{}};
  const auto pixels = sheet(300.3, 200.6, kDistant_px_per_m, kInk);
  EXPECT_TRUE(unit.may_be_centre(view_of(pixels), spot_at(300.3, 200.6, 2.4)));
  EXPECT_FALSE(unit.may_be_centre(view_of(pixels), spot_at(300.3, 200.6, 1.5))) << "too small";
  EXPECT_FALSE(unit.may_be_centre(view_of(pixels), spot_at(300.3, 200.6, 5.2))) << "it is found as it is";
  EXPECT_FALSE(unit.may_be_centre(view_of(pixels), spot_at(100, 100, 2.4))) << "a wall";
  EXPECT_FALSE(unit.may_be_centre(view_of(pixels), spot_at(300.3 + 95 * 0.105, 200.6, 2.4))) << "half of it is wall";
  EXPECT_FALSE(unit.may_be_centre(view_of(pixels), spot_at(2, 2, 2.4))) << "beyond the border nothing is known";
  auto spotted = pixels;
  for (int y = 199; y <= 202; ++y)
    for (int x = 304; x <= 306; ++x) spotted[static_cast<std::size_t>(y * kWidth_px + x)] = kInk;
  EXPECT_FALSE(unit.may_be_centre(view_of(spotted), spot_at(300.3, 200.6, 2.4))) << "another spot where it is blank";
  const auto pale = sheet(300.3, 200.6, kDistant_px_per_m, kInk, 4.0);
  EXPECT_FALSE(unit.may_be_centre(view_of(pale), spot_at(300.3, 200.6, 2.4))) << "a smear";
}

TEST(CloseLook, SeesTheDotsWhereverTheSheetIsInThePicture) {
  CloseLook unit{LandmarkGeometry{}};
  for (const auto& [u, v] : {std::pair{300.3, 200.6}, {11.2, 11.4}, {628.4, 467.7}, {11.0, 300.5}}) {
    const auto pixels = sheet(u, v, kDistant_px_per_m, 90);
    WorkBudget budget;
    BlobList& blobs = unit.blobs_around(view_of(pixels), spot_at(u, v, 2.4), budget);
    const Hypothesis guess = true_guess(u, v, blobs);
    EXPECT_EQ(guess.matched, 9) << u << ", " << v;
    EXPECT_LT(std::sqrt(squared_errors_px2(guess, blobs) / 9), 0.1) << u << ", " << v;
    unit.centre_blobs(view_of(pixels), guess);
    EXPECT_LT(std::sqrt(squared_errors_px2(guess, blobs) / 9), 0.1) << u << ", " << v;
  }
}

/// As a camera that turns sees it, four pixels an exposure; what stands still stays where it is.
std::vector<std::uint8_t> moving(const ImageView& luma) {
  std::vector<std::uint8_t> pixels;
  for (int y = 0; y < luma.height_px; ++y)
    for (int x = 0; x < luma.width_px; ++x) {
      int sum = 0;
      for (int i = -2; i <= 2; ++i)
        sum += (i == -2 || i == 2 ? 1 : 2) * luma.at(std::clamp(x + i, 0, luma.width_px - 1), y);
      pixels.push_back(static_cast<std::uint8_t>(sum / 8));
    }
  return pixels;
}

/// Where a dot's blur meets its neighbour's, the threshold between them cuts it off: of pictures without noise 0.137 px
/// (rms) become 0.112.
TEST(CloseLook, CentresWhatAThresholdHasCut) {
  CloseLook unit{LandmarkGeometry{}};
  double before_px2 = 0, after_px2 = 0;
  for (int i = 0; i < 12; ++i) {
    const double u = 300 + 0.13 * i, v = 200 + 0.29 * i;
    const auto still = sheet(u, v, kDistant_px_per_m, 80);
    const auto pixels = moving(view_of(still));
    WorkBudget budget;
    BlobList& blobs = unit.blobs_around(view_of(pixels), spot_at(u, v, 2.6), budget);
    const Hypothesis guess = true_guess(u, v, blobs);
    EXPECT_GE(guess.matched, 8) << i;
    before_px2 += squared_errors_px2(guess, blobs);
    unit.centre_blobs(view_of(pixels), guess);
    after_px2 += squared_errors_px2(guess, blobs);
  }
  EXPECT_LT(std::sqrt(after_px2 / before_px2), 0.9);
}

test::Picture picture_from(double distance_m, std::uint64_t seed) {
  test::Scene scene;
  scene.camera = test::look_at_landmark(
      {.distance_m = distance_m, .tilt_rad = 0.35, .azimuth_rad = 0.7 * static_cast<double>(seed)});
  set_noise(scene.sensor, 2);
  return test::render(scene, seed);
}

/// Dots of 2.4 px beside a P9 of 4.8: a threshold of half the size takes P9's ink for theirs, or sees no contrast.
TEST(DetectorOfDistantLandmarks, FindsThemByLookingCloser) {
  Detector unit(CameraModel{}, LandmarkGeometry{});
  int found = 0;
  for (std::uint64_t seed = 0; seed < 10; ++seed) {
    const auto pixels = moving(picture_from(7.6, seed).view());
    WorkBudget budget;
    const auto seen = unit.find_all_landmarks(view_of(pixels), budget);
    if (!seen) continue;
    ASSERT_EQ(seen->size(), 1U) << seed;
    ++found;
    // The camera looks at P9.
    EXPECT_NEAR(seen->front().dots[kCentreDot].centroid_px.x(), 319.5, 0.5) << seed;
    EXPECT_NEAR(seen->front().dots[kCentreDot].centroid_px.y(), 239.5, 0.5) << seed;
  }
  EXPECT_GE(found, 9) << "of ten";
}

/// Spots that may be a P9 cost what is counted, however many there are: the next picture goes on with the rest.
TEST(DetectorOfDistantLandmarks, LooksCloserAtSoManySpotsAndNoMore) {
  std::vector<std::uint8_t> pixels(std::size_t{kWidth_px} * kHeight_px, kPaper);
  for (std::size_t y = 10; y + 10 < kHeight_px; y += 20)
    for (std::size_t x = 10; x + 10 < kWidth_px; x += 20)
      for (std::size_t j = 0; j < 5; ++j)
        for (std::size_t i = 0; i < 5; ++i) pixels[(y + j) * kWidth_px + x + i] = kInk;
  Detector unit(CameraModel{}, LandmarkGeometry{});
  WorkBudget budget;
  EXPECT_FALSE(unit.find_all_landmarks(view_of(pixels), budget));
  EXPECT_TRUE(budget.is_overdrawn);
}

/// Each of its nine dots is small, and ink on paper.
TEST(DetectorOfDistantLandmarks, LooksCloserAtNothingOfALandmarkThatItHas) {
  Detector unit(CameraModel{}, LandmarkGeometry{});
  const test::Picture picture = picture_from(4, 1);
  WorkBudget budget;
  ASSERT_TRUE(unit.find_all_landmarks(picture.view(), budget));
  EXPECT_FALSE(budget.is_overdrawn);
}

}  // namespace
}  // namespace ninedot
