// What the detector's constants stand for, measured on rendered landmarks with known truth. Each line that is printed
// backs a constant of firmware/detect, and the assertion below it says that the constant leaves room.
//   build/release/bin/detect_test --gtest_filter='DetectorConstants.*'
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "detect/blob_finder.h"
#include "detect/hypothesis.h"
#include "tests/support/renderer.h"
#include "tests/support/renderer_optics.h"

namespace ninedot {
namespace {

constexpr double kPi = std::numbers::pi;

struct Extremes {
  double ring_radius = 0, slot_rad = 0, area_factor = 1, neighbour_area_factor = 1, cut_ratio = 1;
  double least_neighbour = 10, most_neighbour = 0;
  int dots = 0;
};

Eigen::Matrix2d moments_of(const Blob& b) {
  // As hypothesis.cpp does: point spread and the pixel taken off where grey levels were measured.
  const double scale2 = std::pow(4.0, b.level), blur = b.area_px2 < 120 * scale2 ? 0.44 * scale2 : 0;
  Eigen::Matrix2d M;
  M << std::max(b.xx_px2 - blur, 0.25 * b.xx_px2), b.xy_px2, b.xy_px2, std::max(b.yy_px2 - blur, 0.25 * b.yy_px2);
  return M;
}

const Blob* blob_at(const BlobList& blobs, const Eigen::Vector2d& px, double reach_px) {
  const Blob* best = nullptr;
  for (const Blob& b : blobs) {
    const double distance_px = std::hypot(b.x_px - px.x(), b.y_px - px.y());
    if (distance_px < reach_px) reach_px = distance_px, best = &b;
  }
  return best;
}

/// Seen through each blob's own ellipse, how far the others are from where a frontal view would have them.
void measure(const test::Scene& scene, Extremes& e) {
  const LandmarkGeometry sheet;
  BlobFinder finder(640, 480);
  BlobList blobs;
  const test::Picture picture = test::render(scene, 1);
  WorkBudget budget;
  finder.find_blobs(picture.view(), {}, blobs, budget);
  std::array<const Blob*, kDotCount> dots;
  for (std::size_t i = 0; i < kDotCount; ++i)
    dots[i] = blob_at(blobs, test::centroid_of_disc_px(scene.lens, scene.camera, scene.sheets[0].discs[i]), 1.5);
  const Blob* p9 = dots[kCentreDot];
  if (p9 == nullptr) return;
  const Eigen::Matrix2d whiten = Eigen::LLT<Eigen::Matrix2d>(moments_of(*p9)).matrixL().toDenseMatrix().inverse() / 2;
  const double area_ratio = std::pow(sheet.dot_radius_m / sheet.centre_radius_m, 2);
  double phase_rad = 0;
  bool first = true;
  for (std::size_t i = 0; i < kRingDotCount; ++i) {
    if (dots[i] == nullptr) continue;
    ++e.dots;
    const Eigen::Vector2d n = whiten * Eigen::Vector2d(dots[i]->x_px - p9->x_px, dots[i]->y_px - p9->y_px);
    e.ring_radius = std::max(e.ring_radius, std::abs(n.norm() * sheet.centre_radius_m / sheet.ring_radius_m - 1));
    const double angle_rad = std::atan2(n.y(), n.x()) - static_cast<double>(i) * kPi / 4;
    if (first) phase_rad = angle_rad;
    first = false;
    e.slot_rad = std::max(e.slot_rad, std::abs(std::remainder(angle_rad - phase_rad, 2 * kPi)));
    const double area = dots[i]->area_px2 / (p9->area_px2 * area_ratio);
    e.area_factor = std::max({e.area_factor, area, 1 / area});
    const Blob* next = dots[(i + 1) % kRingDotCount];
    if (next == nullptr) continue;
    const double ratio = next->area_px2 / dots[i]->area_px2;
    e.neighbour_area_factor = std::max({e.neighbour_area_factor, ratio, 1 / ratio});
    const Eigen::Matrix2d own =
        Eigen::LLT<Eigen::Matrix2d>(moments_of(*dots[i])).matrixL().toDenseMatrix().inverse() / 2;
    const double spacing = 2 * std::sin(kPi / 8) * sheet.ring_radius_m / sheet.dot_radius_m;
    const double distance =
        (own * Eigen::Vector2d(next->x_px - dots[i]->x_px, next->y_px - dots[i]->y_px)).norm() / spacing;
    e.least_neighbour = std::min(e.least_neighbour, distance);
    e.most_neighbour = std::max(e.most_neighbour, distance);
  }
}

test::Scene scene_from(double distance_m, double tilt_deg, double azimuth_rad) {
  test::Scene scene;
  scene.camera =
      test::look_at_landmark({.distance_m = distance_m, .tilt_rad = tilt_deg * kPi / 180, .azimuth_rad = azimuth_rad});
  set_noise(scene.sensor, 1.5);
  return scene;
}

void print(const char* name, const Extremes& e) {
  std::printf(
      "%s: %d dots; ring radius off by %.3f, slot by %.3f rad; area factor against P9 %.2f, between neighbours %.2f; "
      "neighbours at %.2f .. %.2f of the spacing\n",
      name, e.dots, e.ring_radius, e.slot_rad, e.area_factor, e.neighbour_area_factor, e.least_neighbour,
      e.most_neighbour);
}

TEST(DetectorConstants, OfTheRingLeaveRoomForPerspectiveAndBlur) {
  Extremes from_centre, from_ring;
  for (const double azimuth_rad : {0.0, 1.2}) {
    for (const double tilt_deg : {40.0, 75.0}) measure(scene_from(0.5, tilt_deg, azimuth_rad), from_centre);
    measure(scene_from(5, 40, azimuth_rad), from_centre);
    for (const double distance_m : {0.5, 2.0}) measure(scene_from(distance_m, 55, azimuth_rad), from_ring);
  }
  print("0.5 m to 75 degrees, 5 m at 40", from_centre);
  print("0.5 and 2 m at 55 degrees", from_ring);
  EXPECT_GT(from_centre.dots, 40);
  EXPECT_LT(from_centre.ring_radius, 0.32);   // kRadiusTolerance
  EXPECT_LT(from_centre.slot_rad, kPi / 16);  // kSlotTolerance_rad
  EXPECT_LT(from_centre.area_factor, 2.2);    // kAreaTolerance
  EXPECT_GT(from_ring.dots, 30);
  EXPECT_LT(from_ring.neighbour_area_factor, 1.7);  // kAreaFactor
  EXPECT_GT(from_ring.least_neighbour, 0.6);        // kNearestSpacing, kFarthestSpacing
  EXPECT_LT(from_ring.most_neighbour, 1.5);
}

}  // namespace
}  // namespace ninedot
