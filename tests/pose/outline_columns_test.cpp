#include "pose/outline_columns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "geometry/transform.h"

namespace ninedot {
namespace {

/// Tilted and aside: rays and places that are large beside what a pixel is of them.
CameraFromLandmark sheet_at(double distance_m) {
  CameraFromLandmark T;
  T.rotation << -1, 0, 0, 0, 0, -1, 0, -1, 0;
  T.rotation = exp_so3(0.6 * Eigen::Vector3d(0.6, 0.8, 0)) * T.rotation;
  T.translation_m = distance_m * Eigen::Vector3d(0.25, 0.1, 1);
  return T;
}

/// Straight ahead, turned about its vertical.
CameraFromLandmark sheet_from(double distance_m, double turned_rad) {
  CameraFromLandmark T;
  T.rotation << -1, 0, 0, 0, 0, -1, 0, -1, 0;
  T.rotation = exp_so3(turned_rad * Eigen::Vector3d::UnitY()) * T.rotation;
  T.translation_m = {0, 0, distance_m};
  return T;
}

/// One column's share of each pixel.
std::vector<double> shares_of(const OutlinePixels& pixels, const OutlineGroup& group, const OutlineState& state,
                              std::size_t column) {
  const DotView view(pixels, {}, state, group.dot);
  const BlurredDisc disc(pixels, {}, state, group.dot, Asked::kState);
  ColumnBatches batches{};
  std::vector<double> shares;
  const auto count = static_cast<std::size_t>(group.count);
  while (shares.size() < count) {
    const std::size_t some = std::min(count - shares.size(), kLanes * kMaxBatches);
    fill_columns(pixels, group, view, disc, {static_cast<std::size_t>(group.first) + shares.size(), some},
                 Asked::kState, batches);
    for (std::size_t i = 0; i < some; ++i)
      shares.push_back(static_cast<double>(batches[i / kLanes][column][i % kLanes]));
  }
  return shares;
}

/// Of each pixel the share that is ink.
std::vector<double> ink_of(const OutlinePixels& pixels, const OutlineGroup& group, const CameraFromLandmark& T) {
  OutlineState state;
  state.T_camera_landmark = T;
  return shares_of(pixels, group, state, kInkColumn);
}

/// By how much a group's outline is off, rms, while the camera turns by steps of a hundred-thousandth of a pixel. [px]
double roughness_px(const OutlinePixels& pixels, const OutlineGroup& group, const CameraFromLandmark& T,
                    const CameraModel& camera) {
  constexpr int kSteps = 60;
  constexpr double kStep_px = 1e-5;
  const auto after = [&](int steps) {
    const Eigen::Matrix3d turn = exp_so3(steps * kStep_px / camera.fx_px * Eigen::Vector3d::UnitY());
    CameraFromLandmark turned = T;
    turned.rotation = turn * T.rotation;
    turned.translation_m = turn * T.translation_m;
    return ink_of(pixels, group, turned);
  };
  const std::vector<double> first = after(0), last = after(kSteps);
  double squares = 0;
  for (int step = 1; step < kSteps; ++step) {
    const std::vector<double> now = after(step);
    double product = 0, square = 0;  // how much of the whole way it has gone
    for (std::size_t i = 0; i < first.size(); ++i) {
      product += (last[i] - first[i]) * (now[i] - first[i]);
      square += (last[i] - first[i]) * (last[i] - first[i]);
    }
    squares += std::pow(product / square * kSteps - step, 2);
  }
  return kStep_px * std::sqrt(squares / kSteps);
}

// What single precision leaves of the places of dots has to be nothing beside the thousandths of a pixel to which they
// are seen, whatever the processor's way of rounding. Reckoned from the camera they were off by 1.6e-5 and 1.3e-5 px,
// all pixels of a dot alike; now it is 6e-6.
TEST(OutlineColumns, SinglePrecisionLeavesADotWhereItIs) {
  const CameraModel camera;
  const RayTable rays(camera);
  const std::vector<std::uint8_t> grey(static_cast<std::size_t>(camera.width_px * camera.height_px), 128);
  const ImageView picture{grey.data(), camera.width_px, camera.height_px, camera.width_px};
  for (const double distance_m : {0.6, 1.2}) {
    const CameraFromLandmark T = sheet_at(distance_m);
    OutlinePixels pixels(12000);
    collect_outline_pixels(picture, camera, rays, {}, T, 3, 1, {}, {}, pixels);
    double sum_px = 0;
    for (const OutlineGroup& group : pixels.groups) sum_px += roughness_px(pixels, group, T, camera);
    ASSERT_GE(pixels.groups.size(), kDotCount);
    EXPECT_LT(sum_px / static_cast<double>(pixels.groups.size()), 9e-6) << "at " << distance_m << " m";
  }
}

// The side of a square sheet comes as near to a dot on a diagonal as to one beside it, seen in the picture.
TEST(OutlineColumns, ADotOnADiagonalSeesBothSidesOnceOneIsNearInThePicture) {
  const CameraModel camera;
  const RayTable rays(camera);
  const std::vector<std::uint8_t> grey(static_cast<std::size_t>(camera.width_px * camera.height_px), 128);
  const ImageView picture{grey.data(), camera.width_px, camera.height_px, camera.width_px};
  constexpr std::size_t kDiagonal = 1, kBeside = 2;
  const auto sides = [&](double distance_m, double turned_rad, double blur_px2, double motion_px2, std::size_t dot) {
    OutlineState state;
    state.T_camera_landmark = sheet_from(distance_m, turned_rad);
    state.blur_px2 = blur_px2 + motion_px2 / 2, state.blur_cos_px2 = motion_px2 / 2;
    OutlinePixels pixels(12000);
    collect_outline_pixels(picture, camera, rays, {}, state.T_camera_landmark, 3, 1, {}, {}, pixels);
    return DotView(pixels, {}, state, dot).beyond.size();
  };
  // 10 px in a picture from in front, and 5 px from aside.
  EXPECT_EQ(sides(2.6, 0, 0.7, 0, kDiagonal), 1U);
  EXPECT_EQ(sides(2.6, 1.05, 0.7, 0, kDiagonal), 2U);
  // A motion of 5 px brings a side of 8 px away into the dot's blur.
  EXPECT_EQ(sides(3.2, 0, 0.7, 0, kDiagonal), 1U);
  EXPECT_EQ(sides(3.2, 0, 0.7, 2.1, kDiagonal), 2U);
  EXPECT_EQ(sides(3.2, 1.05, 0.7, 2.1, kBeside), 1U);
}

/// A dot beside a side of the sheet, 4 m away, in a picture that is grey all over.
struct DotBesideASide {
  explicit DotBesideASide(double blur_px2) {
    state.T_camera_landmark = sheet_from(4, 0);
    state.blur_px2 = blur_px2;
    const CameraModel camera;
    const RayTable rays(camera);
    const std::vector<std::uint8_t> grey(static_cast<std::size_t>(camera.width_px * camera.height_px), 128);
    collect_outline_pixels({grey.data(), camera.width_px, camera.height_px, camera.width_px}, camera, rays, {},
                           state.T_camera_landmark, 3, 1, {}, {}, pixels);
    beside = std::ranges::find(std::as_const(pixels).groups.span(), 2, &OutlineGroup::dot);
  }
  std::vector<double> shares(std::size_t column) const { return shares_of(pixels, *beside, state, column); }

  OutlineState state;
  OutlinePixels pixels{12000};
  std::span<const OutlineGroup>::iterator beside;
};

// A tone curve moves edges into the dark: dots' outlines inwards, the sheet's sides outwards.
TEST(OutlineColumns, TheSheetsSidesAreFurtherOutWhereTheToneHasDotsSmaller) {
  DotBesideASide dot(OutlineState{}.blur_px2);
  ASSERT_TRUE(dot.beside->at_paper_edge);
  const auto beyond_px = [&](double offset_px) {
    dot.state.offset_px = offset_px;
    const std::vector<double> shares = dot.shares(kBeyondColumn);
    return std::accumulate(shares.begin(), shares.end(), 0.0);
  };
  const double without_px = beyond_px(0), with_px = beyond_px(-0.4);
  // A tenth of a pixel, of a strip that is some four pixels long.
  EXPECT_LT(with_px, without_px - 0.3);
  EXPECT_GT(with_px, without_px - 0.6);
  EXPECT_EQ(beyond_px(0.4), without_px) << "no curve moves ink outwards";
  dot.pixels.has_pattern = true;
  EXPECT_NEAR((without_px - beyond_px(-0.4)) / (without_px - with_px), 0.29 / 0.25, 0.02)
      << "what ink does beside the wall is not in it";
  dot.pixels.has_pattern = false;
  dot.pixels.has_tone = true;
  EXPECT_EQ(beyond_px(-0.4), without_px) << "the tone's own column has it";
}

// Taken for a Gaussian's, a side that is drawn along a line was off by a twentieth of the wall's step, and moved the
// dots beside it by a tenth of a pixel.
TEST(OutlineColumns, TheSheetsSidesAreDrawnAlongALineWhereMotionSmears) {
  constexpr double kSharp_px2 = 0.8, kLine_px = 9, kDistance_m = 4;
  constexpr int kSteps = 90;
  DotBesideASide dot(kSharp_px2);
  const double x_m = dot.state.T_camera_landmark.translation_m.x(), px_m = kDistance_m / CameraModel{}.fx_px;
  std::vector<double> drawn(static_cast<std::size_t>(dot.beside->count));
  for (int step = 0; step < kSteps; ++step) {
    dot.state.T_camera_landmark.translation_m.x() = x_m + ((step + 0.5) / kSteps - 0.5) * kLine_px * px_m;
    const std::vector<double> shares = dot.shares(kBeyondColumn);
    for (std::size_t i = 0; i < drawn.size(); ++i) drawn[i] += shares[i] / kSteps;
  }
  dot.state.T_camera_landmark.translation_m.x() = x_m;
  dot.state.blur_px2 += kLine_px * kLine_px / 24, dot.state.blur_cos_px2 = kLine_px * kLine_px / 24;
  const std::vector<double> smeared = dot.shares(kBeyondColumn);
  double worst = 0;
  for (std::size_t i = 0; i < drawn.size(); ++i) worst = std::max(worst, std::abs(smeared[i] - drawn[i]));
  EXPECT_GT(std::ranges::max(drawn), 0.3);
  EXPECT_LT(worst, 0.012);
}

// Ink and wall in one pixel: an sRGB curve takes more off its grey level than off those of either alone. Of a camera
// without a pattern a wide blur's curve has a column of its own, and a narrow blur reaches no two of them.
TEST(OutlineColumns, InkIsDarkerWhereAPixelSeesTheWallAsWell) {
  DotBesideASide dot(1);
  const auto added_share = [&](double offset_px) {
    dot.state.offset_px = offset_px;
    dot.pixels.has_pattern = true;
    const std::vector<double> ink = dot.shares(kInkColumn), beyond = dot.shares(kBeyondColumn);
    dot.pixels.has_pattern = false;
    const std::vector<double> alone = dot.shares(kInkColumn);
    double added = 0, seen_with_wall = 0;
    for (std::size_t i = 0; i < ink.size(); ++i) added += ink[i] - alone[i], seen_with_wall += alone[i] * beyond[i];
    EXPECT_GT(seen_with_wall, 0.01);
    return added / seen_with_wall;
  };
  EXPECT_NEAR(added_share(-0.43), 0.22, 0.01);
  EXPECT_NEAR(added_share(-0.215), 0.11, 0.01) << "half of a curve";
  EXPECT_NEAR(added_share(-0.7), 0.22, 0.01) << "no more than the curve";
  EXPECT_EQ(added_share(0.4), 0) << "no curve moves ink outwards";
}

}  // namespace
}  // namespace ninedot
