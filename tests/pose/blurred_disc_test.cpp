#include "pose/blurred_disc.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

namespace ninedot {
namespace {

constexpr double kFocal_px = 600;
constexpr std::size_t kDot = 1;

CameraFromLandmark sheet_at(double distance_m, double tilt_rad) {
  CameraFromLandmark T;
  // Seen from in front: X0 to the left, Y0 towards the camera, Z0 up.
  T.rotation << -1, 0, 0, 0, 0, -1, 0, -1, 0;
  T.rotation = exp_so3(tilt_rad * Eigen::Vector3d(0.6, 0.8, 0)) * T.rotation;
  T.translation_m = {0.1, -0.2, distance_m};
  return T;
}

OutlinePixels pinhole() {
  OutlinePixels pixels(1);
  pixels.normalised_per_px.fill(Eigen::Matrix2d::Identity() / kFocal_px);
  return pixels;
}

Eigen::Vector2d picture_px(const OutlineState& state, const Eigen::Vector2d& at_m) {
  return kFocal_px * (state.T_camera_landmark * Eigen::Vector3d(at_m.x(), 0, at_m.y())).hnormalized();
}

/// The definition: the blur's Gaussian summed over the disc, in rings and steps around.
double ink_share(const OutlineState& state, const Eigen::Vector2d& pixel_px) {
  constexpr int kRings = 60, kSteps = 120;
  const LandmarkGeometry landmark;
  Eigen::Matrix2d blur;
  blur << state.blur_px2 + state.blur_cos_px2, state.blur_sin_px2, state.blur_sin_px2,
      state.blur_px2 - state.blur_cos_px2;
  const Eigen::Matrix2d certainty = blur.inverse();
  const double r_m = landmark.radius_m(kDot);
  const double dr = r_m / kRings, da = 2 * std::numbers::pi / kSteps;
  double sum = 0;
  for (int ring = 0; ring < kRings; ++ring)
    for (int step = 0; step < kSteps; ++step) {
      const double r = (ring + 0.5) * dr, a = step * da;
      const Eigen::Vector2d towards(std::cos(a), std::sin(a)), at_m = landmark.centre_m(kDot) + r * towards;
      constexpr double kStep_m = 1e-5;
      Eigen::Matrix2d px_per_m;
      for (int axis = 0; axis < 2; ++axis)
        px_per_m.col(axis) =
            (picture_px(state, at_m + kStep_m * Eigen::Vector2d::Unit(axis)) - picture_px(state, at_m)) / kStep_m;
      const Eigen::Vector2d d_px = picture_px(state, at_m) - pixel_px;
      sum += std::abs(px_per_m.determinant()) * r * dr * da * std::exp(-0.5 * d_px.dot(certainty * d_px));
    }
  return sum / (2 * std::numbers::pi * std::sqrt(blur.determinant()));
}

struct Case {
  const char* name;
  double distance_m, tilt_rad, blur_px2, blur_cos_px2, blur_sin_px2;
};
const std::vector<Case> kCases{{"a dot of 2.7 px", 5.6, 0.3, 0.9, 0, 0},
                               {"motion to the side", 5.6, 0.3, 0.9, 0.35, 0},
                               {"motion across", 3.5, 0.7, 1.2, -0.15, 0.3},
                               {"as large as it may be", 3.8, 0.1, 0.8, 0, 0},
                               {"from aside", 4, 1.1, 0.9, 0.2, -0.2}};

OutlineState state_of(const Case& c) {
  OutlineState state;
  state.T_camera_landmark = sheet_at(c.distance_m, c.tilt_rad);
  state.blur_px2 = c.blur_px2, state.blur_cos_px2 = c.blur_cos_px2, state.blur_sin_px2 = c.blur_sin_px2;
  return state;
}

/// Pixels over the dot and around it.
std::vector<Eigen::Vector2d> pixels_around(const OutlineState& state) {
  std::vector<Eigen::Vector2d> pixels;
  for (int y = -3; y <= 3; ++y)
    for (int x = -3; x <= 3; ++x)
      pixels.push_back(picture_px(state, LandmarkGeometry{}.centre_m(kDot)) + 1.3 * Eigen::Vector2d(x, y) +
                       Eigen::Vector2d(0.2, 0.1));
  return pixels;
}

TEST(BlurredDisc, IsWhatAGaussianSumsUpToOverTheDisc) {
  for (const Case& c : kCases) {
    const OutlineState state = state_of(c);
    const BlurredDisc disc(pinhole(), {}, state, kDot, Asked::kLightOnly);
    ASSERT_TRUE(disc.is_small()) << c.name;
    double most = 0;
    for (const Eigen::Vector2d& pixel_px : pixels_around(state)) {
      Lanes x, y, share;
      x.fill(static_cast<float>(pixel_px.x() / kFocal_px)), y.fill(static_cast<float>(pixel_px.y() / kFocal_px));
      disc.ink_share(x, y, share);
      most = std::max(most, std::abs(static_cast<double>(share[0]) - ink_share(state, pixel_px)));
    }
    EXPECT_LT(most, 1e-3) << c.name;
  }
}

// What motion smears is no Gaussian: between the ends of its line a small dot is as dark, and beyond them there is
// none.
TEST(BlurredDisc, IsALineOfDiscsWhereMotionSmears) {
  constexpr double kNarrow_px2 = 0.8;
  for (const auto& [length_px, angle_rad] : {std::pair{4.5, 0.0}, {8.0, 0.4}, {11.0, -1.2}}) {
    const Case still{"", 4.5, 0.3, kNarrow_px2, 0, 0};
    const double half_px2 = length_px * length_px / 24;
    OutlineState smeared = state_of(still);
    smeared.blur_px2 += half_px2;
    smeared.blur_cos_px2 = half_px2 * std::cos(2 * angle_rad),
    smeared.blur_sin_px2 = half_px2 * std::sin(2 * angle_rad);
    const Eigen::Vector2d line_px = length_px * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad));
    EXPECT_LT((Smear(smeared).line_px - line_px).norm(), 1e-9);
    const BlurredDisc disc(pinhole(), {}, smeared, kDot, Asked::kLightOnly);
    ASSERT_TRUE(disc.is_small());
    for (int along = -12; along <= 12; ++along) {
      const Eigen::Vector2d pixel_px =
          picture_px(smeared, LandmarkGeometry{}.centre_m(kDot)) + 0.1 * along * line_px + Eigen::Vector2d(0.3, -0.6);
      constexpr int kParts = 24;
      double truth = 0;
      for (int part = 0; part < kParts; ++part)
        truth += ink_share(state_of(still), pixel_px - ((part + 0.5) / kParts - 0.5) * line_px) / kParts;
      Lanes x, y, share;
      x.fill(static_cast<float>(pixel_px.x() / kFocal_px)), y.fill(static_cast<float>(pixel_px.y() / kFocal_px));
      disc.ink_share(x, y, share);
      EXPECT_NEAR(static_cast<double>(share[0]), truth, 0.015) << length_px << " px, " << along;
      EXPECT_TRUE(disc.reaches_any(x, y) || truth < 1e-3);
      std::array<Lanes, kMoveColumns> moves;
      std::array<Lanes, kBlurColumns> blur;
      BlurredDisc(pinhole(), {}, smeared, kDot, Asked::kState).ink_share(x, y, share, moves, blur);
      const auto share_after = [&](const auto& change) {
        OutlineState moved = smeared;
        change(moved);
        Lanes other;
        BlurredDisc(pinhole(), {}, moved, kDot, Asked::kLightOnly).ink_share(x, y, other);
        return static_cast<double>(other[0]);
      };
      const auto after_move = [&](double by_m) {
        return share_after([&](OutlineState& moved) {
          moved.T_camera_landmark.translation_m += by_m * smeared.T_camera_landmark.rotation.col(0);
        });
      };
      const double numeric = -(after_move(1e-3) - after_move(-1e-3)) / 2e-3;
      EXPECT_NEAR(static_cast<double>(moves[3][0]), numeric, 1) << along;  // of 10 to 40 at the line's ends
      // A longer line reaches further and is brighter; more of a Gaussian would be neither.
      const std::array by_unknown{&OutlineState::blur_px2, &OutlineState::blur_cos_px2, &OutlineState::blur_sin_px2};
      for (std::size_t k = 0; k < kBlurColumns; ++k) {
        constexpr double kStep_px2 = 0.01;
        const auto after = [&](double by_px2) {
          return share_after([&](OutlineState& moved) { moved.*by_unknown[k] += by_px2; });
        };
        EXPECT_NEAR(static_cast<double>(blur[k][0]), -(after(kStep_px2) - after(-kStep_px2)) / (2 * kStep_px2), 0.004)
            << length_px << " px, " << along << ", " << k;  // of 0.05 to 0.13
      }
    }
    Lanes far_x, far_y;
    far_x.fill(static_cast<float>(picture_px(smeared, LandmarkGeometry{}.centre_m(kDot)).x() / kFocal_px + 0.1));
    far_y.fill(0);
    EXPECT_FALSE(disc.reaches_any(far_x, far_y));
  }
}

/// Three pixels of motion are no line in a picture that is out of focus.
TEST(Smear, IsLongerThanItsBlurIsWide) {
  OutlineState state;
  state.blur_px2 = 1.1, state.blur_cos_px2 = 0.3, state.blur_sin_px2 = -0.3;
  EXPECT_EQ(Smear(state).parts, 2U);
  state.blur_px2 = 4;
  EXPECT_EQ(Smear(state).parts, 1U);
  state.blur_px2 += 4, state.blur_cos_px2 += 4;
  EXPECT_EQ(Smear(state).parts, 2U) << "10 px, and a blur of 2 px across";
}

// A blur that is wide along an outline reaches over its bend: a profile across it is off by up to half a pixel.
TEST(BlurredDisc, IsOneUpToTwiceTheSizeWhereTheToneIsFitted) {
  const OutlineState state = state_of({"a little motion past a dot of 7 px", 2.3, 0.3, 1.8, 0.35, 0});
  OutlinePixels pixels = pinhole();
  EXPECT_FALSE(BlurredDisc(pixels, {}, state, kDot, Asked::kLightOnly).is_small());
  pixels.has_tone = true;
  const BlurredDisc disc(pixels, {}, state, kDot, Asked::kLightOnly);
  ASSERT_TRUE(disc.is_small());
  for (const Eigen::Vector2d& pixel_px : pixels_around(state)) {
    Lanes x, y, share;
    x.fill(static_cast<float>(pixel_px.x() / kFocal_px)), y.fill(static_cast<float>(pixel_px.y() / kFocal_px));
    disc.ink_share(x, y, share);
    EXPECT_NEAR(static_cast<double>(share[0]), ink_share(state, pixel_px), 2e-3);
  }
}

TEST(BlurredDisc, ColumnsAreCentralDifferencesOfTheGreyLevel) {
  for (const Case& c : kCases) {
    const OutlineState state = state_of(c);
    const BlurredDisc disc(pinhole(), {}, state, kDot, Asked::kState);
    for (const Eigen::Vector2d& pixel_px : pixels_around(state)) {
      Lanes x, y, share;
      x.fill(static_cast<float>(pixel_px.x() / kFocal_px)), y.fill(static_cast<float>(pixel_px.y() / kFocal_px));
      std::array<Lanes, kMoveColumns> moves;
      std::array<Lanes, kBlurColumns> blur;
      disc.ink_share(x, y, share, moves, blur);
      for (int i = 0; i < kToneUnknown; ++i) {
        const double by = i < kPoseUnknowns ? 1e-4 : 1e-2;
        UnknownVector step = UnknownVector::Zero();
        step(i) = by;
        if (i < kPoseUnknowns)  // along the sheet's axes
          step.segment<3>(i / 3 * 3) = by * state.T_camera_landmark.rotation.col(i % 3);
        OutlineState more = state, less = state;
        more.apply(step), less.apply(-step);
        const double numeric = -(ink_share(more, pixel_px) - ink_share(less, pixel_px)) / (2 * by);
        const auto column = static_cast<std::size_t>(i);
        const double ours =
            static_cast<double>(column < kMoveColumns ? moves[column][0] : blur[column - kMoveColumns][0]);
        if (i == kPoseUnknowns) continue;  // the offset is no part of it
        EXPECT_NEAR(ours, numeric, i < kPoseUnknowns ? 0.8 : 4e-3) << c.name << ", unknown " << i;
      }
    }
  }
}

// Ink that has spread is more ink.
TEST(BlurredDisc, AnOffsetIsAnotherRadiusAndItsAreaWhereTheToneIsFitted) {
  OutlineState printed = state_of(kCases[0]);
  printed.T_camera_landmark = sheet_at(5.6, 0);
  OutlineState spread = printed;
  spread.offset_px = 0.3;
  LandmarkGeometry larger;
  larger.dot_radius_m += 0.3 * 5.6 / kFocal_px;
  OutlinePixels pixels = pinhole();
  pixels.has_tone = true;
  const BlurredDisc disc(pixels, {}, spread, kDot, Asked::kLightOnly),
      other(pixels, larger, printed, kDot, Asked::kLightOnly);
  for (const Eigen::Vector2d& pixel_px : pixels_around(printed)) {
    Lanes x, y, share, expected;
    x.fill(static_cast<float>(pixel_px.x() / kFocal_px)), y.fill(static_cast<float>(pixel_px.y() / kFocal_px));
    disc.ink_share(x, y, share);
    other.ink_share(x, y, expected);
    EXPECT_NEAR(static_cast<double>(share[0]), static_cast<double>(expected[0]), 2e-3);
  }
}

/// A shrunk disc's picture times what it has shrunk by: the group's contrast takes that out.
TEST(BlurredDisc, AnOffsetIsAnotherRadius) {
  OutlineState shrunk = state_of(kCases[0]), whole = shrunk;
  shrunk.T_camera_landmark = whole.T_camera_landmark = sheet_at(5.6, 0);
  const double px_per_m = kFocal_px / 5.6, r_px = LandmarkGeometry{}.radius_m(kDot) * px_per_m;
  shrunk.offset_px = -0.3;
  LandmarkGeometry smaller;
  smaller.dot_radius_m = (r_px - 0.3) / px_per_m;
  const BlurredDisc disc(pinhole(), {}, shrunk, kDot, Asked::kLightOnly),
      other(pinhole(), smaller, whole, kDot, Asked::kLightOnly);
  for (const Eigen::Vector2d& pixel_px : pixels_around(whole)) {
    Lanes x, y, share, expected;
    x.fill(static_cast<float>(pixel_px.x() / kFocal_px)), y.fill(static_cast<float>(pixel_px.y() / kFocal_px));
    disc.ink_share(x, y, share);
    other.ink_share(x, y, expected);
    EXPECT_NEAR(static_cast<double>(share[0]), static_cast<double>(expected[0]) * r_px / (r_px - 0.3), 2e-3);
  }
}

TEST(BlurredDisc, LeavesDotsThatAreLargeBesideTheirBlurToTheProfile) {
  OutlineState state;
  state.T_camera_landmark = sheet_at(1, 0.3);
  EXPECT_FALSE(BlurredDisc(pinhole(), {}, state, kDot, Asked::kState).is_small());
  EXPECT_FALSE(BlurredDisc(pinhole(), {}, state, kCentreDot, Asked::kState).is_small());
  state.blur_px2 = 9;  // out of focus it is small
  EXPECT_TRUE(BlurredDisc(pinhole(), {}, state, kDot, Asked::kState).is_small());
}

}  // namespace
}  // namespace ninedot
