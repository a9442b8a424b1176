// What a way to a pose says of itself beside the pose.
#include "pipeline/landmark_seeker.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <functional>
#include <vector>

#include "tests/support/renderer.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

constexpr double kDistance_m = 1.5;
constexpr double kRowTime_s = 33e-6;

test::Picture picture_of(const std::vector<test::Sheet>& sheets, double distance_m) {
  test::Scene scene;
  scene.camera = test::look_at_landmark({.distance_m = distance_m, .tilt_rad = 0.4, .azimuth_rad = 0.7});
  scene.sheets = sheets;
  set_noise(scene.sensor, 1.5);
  return test::render(scene, 1);
}

/// The picture moved to the right, its left border repeated.
std::vector<std::uint8_t> moved(const ImageView& luma, int by_px) {
  std::vector<std::uint8_t> pixels;
  for (int y = 0; y < luma.height_px; ++y)
    for (int x = 0; x < luma.width_px; ++x) pixels.push_back(luma.at(std::max(x - by_px, 0), y));
  return pixels;
}

/// A landmark that is in another place in each of four frames, through a rolling shutter.
class Passing {
 public:
  explicit Passing(int step_px, std::chrono::milliseconds period = 28ms) : step_px_(step_px), period_(period) {}

  Result<std::size_t> look(int number, bool follows_outlines) { return look(number, follows_outlines, number); }
  /// \param steps  of the way
  Result<std::size_t> look(int steps, bool follows_outlines, int number) {
    pixels_ = moved(picture_.view(), steps * step_px_);
    Frame frame;
    frame.luma = {pixels_.data(), picture_.view().width_px, picture_.view().height_px, picture_.view().width_px};
    frame.set_exposure(MonoTime(1s) + number * period_, 4ms);
    seeker.begin(frame, WorkBudget{}, {kRowTime_s});
    if (number > 0) return follows_outlines ? seeker.follow_outlines(track_) : seeker.detect_near_track(track_);
    const auto seen = seeker.detector().find_landmarks(frame.luma);
    return seen ? seeker.solve_guess(seen->front(), track_) : tl::unexpected(seen.error());
  }
  double rate_sigma_rad_s() const { return seeker.row_motion().uncertainty.of_motion_rad / kRowTime_s; }

  LandmarkSeeker seeker{CameraModel{}, {}};

 private:
  int step_px_;
  std::chrono::milliseconds period_;
  test::Picture picture_ = picture_of({test::nine_dot_sheet()}, kDistance_m);
  std::vector<std::uint8_t> pixels_;
  Track track_{TrackOptions{}};
};

/// Of one frame alone nothing is known; where it was before and where its dots are now tells the second how it moves.
TEST(LandmarkSeeker, SaysHowWellTheMotionAcrossRowsWasKnownWhenItWasFitted) {
  constexpr int kStep_px = 12;
  Passing unit(kStep_px);
  for (int number = 0; number < 4; ++number) {
    ASSERT_TRUE(unit.look(number, false)) << number;
    const RowMotion& fitted = unit.seeker.row_motion();
    EXPECT_EQ(fitted.sheet.row_time_s, kRowTime_s) << number;
    if (number == 0) {
      EXPECT_GT(unit.rate_sigma_rad_s(), 0.5);
      EXPECT_EQ(fitted.sheet.translation_m_s.norm(), 0);
      continue;
    }
    EXPECT_LT(unit.rate_sigma_rad_s(), number == 1 ? 0.05 : 0.01) << number;
    const double speed_m_s = kStep_px / CameraModel{}.fx_px * kDistance_m / 0.028;
    EXPECT_NEAR(fitted.sheet.translation_m_s.x(), speed_m_s, 0.03 * speed_m_s) << number;
    EXPECT_NEAR(fitted.sheet.translation_m_s.y(), 0, 0.03 * speed_m_s) << number;
    const SheetMotion& taken = unit.seeker.candidates().list[0].outlines.motion;
    EXPECT_NEAR(taken.translation_m_s.x(), speed_m_s, 0.05 * speed_m_s) << number << ", by the fit already";
  }
}

/// The second frame's outlines are looked for where the first had them: it can't have moved far.
TEST(LandmarkSeeker, KnowsOfALandmarkThatIsFoundWhereItWasThatItHardlyMoved) {
  Passing unit(0);
  ASSERT_TRUE(unit.look(0, true));
  EXPECT_GT(unit.rate_sigma_rad_s(), 0.5);
  ASSERT_TRUE(unit.look(1, true));
  EXPECT_LT(unit.rate_sigma_rad_s(), 0.05);
  EXPECT_GT(unit.rate_sigma_rad_s(), 0.01) << "of two frames, not of a track";
}

/// At 8 pictures a second a head may have gained a sixteenth of a radian per second since the middle of two.
TEST(LandmarkSeeker, IsTheLessSureOfTwoFramesTheFartherTheyAreApart) {
  Passing unit(12, 125ms);
  ASSERT_TRUE(unit.look(0, false));
  ASSERT_TRUE(unit.look(1, false));
  EXPECT_GT(unit.rate_sigma_rad_s(), 0.06);
  EXPECT_LT(unit.rate_sigma_rad_s(), 0.07);
}

/// A fit that begins where nothing is goes astray for long: a search has to be possible after it.
TEST(LandmarkSeeker, LeavesPixelsForASearchWhereALookFindsNothing) {
  const test::Picture picture = picture_of({test::nine_dot_sheet()}, kDistance_m);
  LandmarkSeeker seeker(CameraModel{}, {});
  Frame frame;
  frame.luma = picture.view();
  frame.set_exposure(MonoTime(1s), 4ms);
  constexpr int kPixels = 26'000;
  int most_taken = 0;
  for (const double aside_m : {-0.06, -0.03, 0.03, 0.06})
    for (const double further : {0.8, 1.1, 1.4}) {
      seeker.begin(frame, WorkBudget{.pixels = kPixels}, {});
      CameraFromLandmark there;
      there.rotation << -1, 0, 0, 0, 0, -1, 0, -1, 0;
      there.translation_m = {aside_m, 0, further * kDistance_m};
      Track track{TrackOptions{}};
      (void)seeker.look_at(there, track);
      most_taken = std::max(most_taken, kPixels - seeker.budget().pixels);
    }
  EXPECT_GT(most_taken, kPixels / 8) << "it did look";
  EXPECT_LT(most_taken, kPixels / 2);
}

/// A camera that begins to turn: the speed is what it is at the last frame, not between the two or as it was foretold.
TEST(LandmarkSeeker, KnowsTheSpeedOfTheFrameItselfWhereThatGrows) {
  constexpr double kStep_s = 0.028;
  Passing unit(1);
  for (int number = 0; number < 6; ++number) {
    ASSERT_TRUE(unit.look(number * number, false, number)) << number;  // the n-th frame is n^2 px further on
    if (number < 2) continue;
    const double speed_m_s = 2 * number / CameraModel{}.fx_px * kDistance_m / kStep_s;
    EXPECT_NEAR(unit.seeker.row_motion().sheet.translation_m_s.x(), speed_m_s, 0.015)
        << number;  // between the frames it is 0.074 less
  }
}

/// A landmark that comes into view may move as those do that are there.
TEST(CameraUnrest, IsOfTheFastestAndFades) {
  CameraUnrest unrest;
  unrest.begin(MonoTime(1s));
  EXPECT_EQ(unrest.speed_rad_s(), 0.7);
  EXPECT_EQ(unrest.acceleration_rad_s2(), 1);
  unrest.note(2, 8);
  unrest.note(1, 3);
  EXPECT_EQ(unrest.speed_rad_s(), 2);
  EXPECT_EQ(unrest.acceleration_rad_s2(), 8);
  unrest.begin(MonoTime(1100ms));
  EXPECT_NEAR(unrest.acceleration_rad_s2(), 6.5, 0.1);
  EXPECT_NEAR(unrest.unexpected_rad_s(), 0.1 * 5.5, 0.01);
  unrest.begin(MonoTime(5s));
  EXPECT_EQ(unrest.speed_rad_s(), 0.7);
  EXPECT_EQ(unrest.unexpected_rad_s(), 0);
}

/// A sheet in a share of its size, its middle moved along the wall.
test::Sheet hung(test::Sheet sheet, double size, double x_m) {
  sheet.x_m = x_m;
  sheet.width_m *= size, sheet.height_m *= size;
  for (test::Disc& disc : sheet.discs) disc.x_m = x_m + size * disc.x_m, disc.z_m *= size, disc.radius_m *= size;
  for (test::Bar& bar : sheet.bars) {
    bar.x0_m = x_m + size * bar.x0_m, bar.x1_m = x_m + size * bar.x1_m;
    bar.z0_m *= size, bar.z1_m *= size, bar.width_m *= size;
  }
  return sheet;
}

/// What is too small to be told from a landmark may be more of what was near enough: a wall of such things is none of
/// its far ones either. Of the next frame that says nothing.
TEST(LandmarkSeeker, TakesNothingSmallerThanALookAlikeInTheSameFrame) {
  LandmarkSeeker unit{CameraModel{}, {}};
  const auto taken = [&](const std::vector<test::Sheet>& sheets) {
    const test::Picture picture = picture_of(sheets, kDistance_m);
    Frame frame;
    frame.luma = picture.view();
    unit.begin(frame, WorkBudget{}, {});
    const auto all = unit.detector().find_all_landmarks(frame.luma, unit.budget());
    if (!all) return -1;
    std::vector<LandmarkObservation> seen(all->begin(), all->end());
    std::ranges::sort(seen, std::greater{}, [](const auto& one) { return one.H_ray_plane.col(0).norm(); });
    EXPECT_EQ(seen.size(), sheets.size());
    return static_cast<int>(std::ranges::count_if(seen, [&](const auto& one) {
      Track track{TrackOptions{}};
      return unit.solve_guess(one, track).has_value();
    }));
  };
  const auto landmark = [](double size) { return hung(test::nine_dot_sheet(), size, 0.13); };
  const auto squares = [](double size) { return hung(test::square_dot_sheet(), size, -0.13); };
  EXPECT_EQ(taken({squares(1)}), 0);
  EXPECT_EQ(taken({squares(1), landmark(0.7)}), 0);
  EXPECT_EQ(taken({landmark(0.7)}), 1) << "in the next frame";
  EXPECT_EQ(taken({squares(0.7), landmark(1)}), 1);
}

}  // namespace
}  // namespace ninedot
