#include "pose/outline_pixels.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <set>
#include <utility>
#include <vector>

namespace ninedot {
namespace {

constexpr double kFocal_px = 600;

CameraModel camera() {
  CameraModel lens;
  lens.fx_px = lens.fy_px = kFocal_px;
  return lens;
}

/// Seen straight from in front, so that an outline is a circle.
CameraFromLandmark sheet_at(double distance_m) {
  CameraFromLandmark T;
  T.rotation << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  T.translation_m = {0, 0, distance_m};
  return T;
}

/// From a pixel to the outline of the dot, from outside.
double to_outline_px(const LandmarkGeometry& landmark, const CameraFromLandmark& T, std::size_t dot, float x, float y) {
  const Eigen::Vector2d C = landmark.centre_m(dot);
  const Eigen::Vector2d middle_px =
      camera().pixel_from_normalised((T * Eigen::Vector3d(C.x(), 0, C.y())).hnormalized());
  return (Eigen::Vector2d(x, y) - middle_px).norm() - kFocal_px * landmark.radius_m(dot) / T.translation_m.z();
}

/// At 6 m neighbours on the ring are two blurs apart: what sees both would tell each dot of the other's ink.
TEST(OutlinePixels, NoneOfADistantDotSeesItsNeighboursInk) {
  const CameraModel lens = camera();
  const LandmarkGeometry landmark;
  const RayTable rays(lens);
  const std::vector<std::uint8_t> grey(
      static_cast<std::size_t>(lens.width_px) * static_cast<std::size_t>(lens.height_px), 128);
  const ImageView luma{grey.data(), lens.width_px, lens.height_px, lens.width_px};
  const CameraFromLandmark T = sheet_at(6);
  OutlinePixels pixels(4000);
  collect_outline_pixels(luma, lens, rays, landmark, T, 3.0, 1, {}, {}, pixels);
  ASSERT_EQ(pixels.visible_outlines, 9);
  double nearest_other_px = std::numeric_limits<double>::infinity();
  int beyond_own = 0;
  for (const OutlineGroup& group : pixels.groups)
    for (std::int32_t i = group.first; i < group.first + group.count; ++i) {
      const float x = pixels.x_px[static_cast<std::size_t>(i)], y = pixels.y_px[static_cast<std::size_t>(i)];
      const double own_px = to_outline_px(landmark, T, group.dot, x, y);
      if (own_px > 1) ++beyond_own;
      for (std::size_t other = 0; other < kDotCount; ++other)
        if (other != group.dot)
          nearest_other_px = std::min(nearest_other_px, to_outline_px(landmark, T, other, x, y) - own_px);
    }
  EXPECT_GT(nearest_other_px, -0.1) << "a pixel lies nearer to another dot than to its own";
  EXPECT_GT(beyond_own, 50) << "the paper around them is looked at";
}

/// Grey levels that tell pixels apart.
std::vector<std::uint8_t> greys_of(const CameraModel& lens) {
  std::vector<std::uint8_t> grey(static_cast<std::size_t>(lens.width_px) * static_cast<std::size_t>(lens.height_px));
  for (std::size_t i = 0; i < grey.size(); ++i) grey[i] = static_cast<std::uint8_t>(i * 37 % 251);
  return grey;
}

/// How many pixels were collected, each with its own ray and grey level.
struct Collected {
  std::size_t all = 0, distinct = 0;
};
Collected count_of(const OutlinePixels& pixels, const RayTable& rays, const ImageView& luma) {
  Collected collected;
  std::set<std::pair<int, int>> seen;
  for (const OutlineGroup& group : pixels.groups) {
    double sum_x_px = 0, sum_y_px = 0;
    for (std::int32_t n = group.first; n < group.first + group.count; ++n) {
      const auto i = static_cast<std::size_t>(n);
      const int x = static_cast<int>(pixels.x_px[i]), y = static_cast<int>(pixels.y_px[i]);
      seen.insert({x, y});
      ++collected.all;
      float ray_x = 0, ray_y = 0;
      EXPECT_TRUE(rays.ray(x, y, ray_x, ray_y));
      EXPECT_FLOAT_EQ(pixels.ray_x[i], ray_x);
      EXPECT_FLOAT_EQ(pixels.ray_y[i], ray_y);
      EXPECT_EQ(pixels.luma[i], static_cast<float>(luma.at(x, y)));
      sum_x_px += x, sum_y_px += y;
    }
    EXPECT_NEAR(static_cast<double>(group.centre_x_px), sum_x_px / group.count, 1e-3);
    EXPECT_NEAR(static_cast<double>(group.centre_y_px), sum_y_px / group.count, 1e-3);
  }
  collected.distinct = seen.size();
  return collected;
}

/// Opposite sides of a dot that is one group say of its outline's place what stretches of it, each with grey levels of
/// its own, do not.
TEST(OutlinePixels, RingDotsAreOneGroupUpTo12PxAndTheCentreUpTo7Px) {
  const CameraModel lens = camera();
  const RayTable rays(lens);
  const std::vector<std::uint8_t> grey(
      static_cast<std::size_t>(lens.width_px) * static_cast<std::size_t>(lens.height_px), 128);
  const ImageView luma{grey.data(), lens.width_px, lens.height_px, lens.width_px};
  OutlinePixels pixels(12000);
  const auto groups_at = [&](double distance_m) {
    collect_outline_pixels(luma, lens, rays, {}, sheet_at(distance_m), 3.0, 1, {}, {}, pixels);
    std::array<int, kDotCount> groups{};
    for (const OutlineGroup& group : pixels.groups) ++groups[group.dot];
    return groups;
  };
  EXPECT_GE(groups_at(0.6)[0], 8) << "12.7 px";
  EXPECT_EQ(groups_at(0.7)[0], 1) << "10.9 px";
  EXPECT_GE(groups_at(2.0)[kCentreDot], 8) << "7.6 px";
  EXPECT_EQ(groups_at(2.4)[kCentreDot], 1) << "6.4 px";
}

/// Small dots as a whole, larger ones in sectors, thinned and not.
TEST(OutlinePixels, EveryPixelOfTheBandIsThereOnce) {
  constexpr double kBand_px = 3;
  const CameraModel lens = camera();
  const LandmarkGeometry landmark;
  const RayTable rays(lens);
  const std::vector<std::uint8_t> grey = greys_of(lens);
  const ImageView luma{grey.data(), lens.width_px, lens.height_px, lens.width_px};
  for (const double distance_m : {0.6, 1.0, 1.7})
    for (const int thin : {1, 3}) {
      const CameraFromLandmark T = sheet_at(distance_m);
      OutlinePixels pixels(12000);
      collect_outline_pixels(luma, lens, rays, landmark, T, kBand_px, thin, {}, {}, pixels);
      std::size_t expected = 0;
      for (std::size_t dot = 0; dot < kDotCount; ++dot)
        for (int y = 0; y < lens.height_px; ++y)
          for (int x = 0; x < lens.width_px; ++x)
            expected += (x + 2 * y) % thin == 0 && std::abs(to_outline_px(landmark, T, dot, static_cast<float>(x),
                                                                          static_cast<float>(y))) < kBand_px;
      const Collected collected = count_of(pixels, rays, luma);
      EXPECT_EQ(collected.distinct, collected.all);
      EXPECT_NEAR(static_cast<double>(collected.all), static_cast<double>(expected), 8)
          << distance_m << " m, every " << thin;
    }
}

TEST(OutlinePixels, OfADistortedLensHaveTheRaysOfTheTable) {
  CameraModel lens = camera();
  lens.k = {-0.21, 0.07, 0.001, -0.0008, 0.02};
  const RayTable rays(lens);
  const std::vector<std::uint8_t> grey = greys_of(lens);
  const ImageView luma{grey.data(), lens.width_px, lens.height_px, lens.width_px};
  for (const double distance_m : {0.6, 1.7}) {
    OutlinePixels pixels(12000);
    collect_outline_pixels(luma, lens, rays, LandmarkGeometry{}, sheet_at(distance_m), 3, 1, {}, {}, pixels);
    EXPECT_GT(count_of(pixels, rays, luma).distinct, 1000U) << distance_m;
  }
}

/// A fisheye lens sees beyond a right angle, where a plane at z = 1 has no point: what has no ray is left out.
TEST(OutlinePixels, WithoutARayAreLeftOut) {
  CameraModel lens;
  lens.model = DistortionModel::kEquidistant;
  lens.fx_px = lens.fy_px = 200;
  const RayTable rays(lens);
  ASSERT_TRUE(rays.has_gaps());
  const std::vector<std::uint8_t> grey = greys_of(lens);
  const ImageView luma{grey.data(), lens.width_px, lens.height_px, lens.width_px};
  CameraFromLandmark T = sheet_at(0.8);
  const Eigen::Matrix3d aside = Eigen::AngleAxisd(1.475, Eigen::Vector3d::UnitY()).toRotationMatrix();
  T.rotation = aside * T.rotation;
  T.translation_m = aside * T.translation_m;
  OutlinePixels pixels(12000);
  collect_outline_pixels(luma, lens, rays, LandmarkGeometry{}, T, 4, 1, {}, {}, pixels);
  EXPECT_GT(count_of(pixels, rays, luma).distinct, 300U);
}

/// Of a grey picture.
OutlinePixels pixels_of(const CameraFromLandmark& T, double band_px) {
  const CameraModel lens = camera();
  const RayTable rays(lens);
  const std::vector<std::uint8_t> grey(
      static_cast<std::size_t>(lens.width_px) * static_cast<std::size_t>(lens.height_px), 128);
  OutlinePixels pixels(20000);
  collect_outline_pixels({grey.data(), lens.width_px, lens.height_px, lens.width_px}, lens, rays, {}, T, band_px, 1, {},
                         {}, pixels);
  return pixels;
}

/// A sheet of which one sees hardly more than its edge: an ellipse with the band's width on all sides of its short one
/// would be eight times as long as the dot.
TEST(OutlinePixels, OfANarrowOutlineLieNoFartherFromItThanTwiceTheBand) {
  constexpr double kBand_px = 6;
  const CameraModel lens = camera();
  const LandmarkGeometry landmark;
  CameraFromLandmark T = sheet_at(1.0);
  T.rotation = Eigen::AngleAxisd(85 * M_PI / 180, Eigen::Vector3d::UnitX()).toRotationMatrix() * T.rotation;
  const OutlinePixels pixels = pixels_of(T, kBand_px);
  ASSERT_GT(pixels.groups.size(), 0U);
  for (const OutlineGroup& group : pixels.groups) {
    const Eigen::Vector2d C = landmark.centre_m(group.dot);
    const Eigen::Vector3d middle_m = T * Eigen::Vector3d(C.x(), 0, C.y());
    const Eigen::Vector2d middle_px = lens.pixel_from_normalised(middle_m.hnormalized());
    const double reach_px = kFocal_px * landmark.radius_m(group.dot) / middle_m.z() + 2 * kBand_px + 0.5;
    for (std::int32_t i = group.first; i < group.first + group.count; ++i) {
      const auto at = static_cast<std::size_t>(i);
      EXPECT_LT((Eigen::Vector2d(pixels.x_px[at], pixels.y_px[at]) - middle_px).norm(), reach_px) << int(group.dot);
    }
  }
}

TEST(OutlinePixels, TakeMoreWorkToCollectWhereDotsSeeEachOthersInk) {
  const auto work_per_pixel = [&](double distance_m) {
    const OutlinePixels pixels = pixels_of(sheet_at(distance_m), 3.0);
    return static_cast<double>(pixels.work_px) / static_cast<double>(pixels.count);
  };
  EXPECT_GT(work_per_pixel(1), 0.03);
  EXPECT_LT(work_per_pixel(1), 0.1);
  EXPECT_GT(work_per_pixel(6), 0.4);
}

}  // namespace
}  // namespace ninedot
