#include "track/track.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <numbers>

#include "geometry/renumbered.h"
#include "pose/mirror_image.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

constexpr double kFocal_px = 720;

/// 2 m in front of the sheet, leaning by `tilt_rad`, moved sideways by `x_m`.
CameraFromLandmark sheet_at(double tilt_rad, double x_m = 0) {
  // S0 -> camera for a frontal view: X0 to the viewer's left, Y0 towards the viewer, Z0 up.
  Eigen::Matrix3d frontal;
  frontal << -1, 0, 0, 0, 0, -1, 0, -1, 0;
  return {exp_so3({0, tilt_rad, 0}) * frontal, {x_m, 0, 2}};
}

PoseCandidate reading(const CameraFromLandmark& T, double chi2_above = 0) {
  PoseCandidate candidate;
  candidate.pose.T_landmark_camera = T.inverse();
  candidate.pose.covariance = Matrix6d::Identity() * 1e-8;
  candidate.pose.dots_used = 9;
  candidate.pose.rms_px = 0.1;
  candidate.pose.ellipse.distance_m = 2;
  candidate.outlines.T_camera_landmark = T;
  candidate.chi2_above = chi2_above;
  return candidate;
}

PoseCandidates readings(std::initializer_list<PoseCandidate> list) {
  PoseCandidates candidates;
  for (const PoseCandidate& candidate : list) EXPECT_TRUE(candidates.list.try_push_back(candidate));
  return candidates;
}

std::size_t taken(Track& track, PoseCandidates candidates, MonoTime at) {
  track.see({});
  const auto chosen = track.take(candidates, at);
  EXPECT_TRUE(chosen.has_value());
  return chosen.value_or(99);
}

PoseEstimate plausible_pose() { return reading(sheet_at(0.3)).pose; }

TEST(Publishable, IsOnlyAPoseOfFiniteNumbersWithAnUncertainty) {
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(is_publishable(plausible_pose()));
  const auto broken = [](auto&& breakage) {
    PoseEstimate pose = plausible_pose();
    breakage(pose);
    return !is_publishable(pose);
  };
  EXPECT_TRUE(broken([](PoseEstimate& p) { p.T_landmark_camera.translation_m.x() = kNan; }));
  EXPECT_TRUE(broken([](PoseEstimate& p) { p.T_landmark_camera.rotation(1, 2) = kNan; }));
  EXPECT_TRUE(broken([](PoseEstimate& p) { p.covariance(4, 1) = std::numeric_limits<double>::infinity(); }));
  EXPECT_TRUE(broken([](PoseEstimate& p) { p.covariance(3, 3) = 0; }));
  EXPECT_TRUE(broken([](PoseEstimate& p) { p.rms_px = kNan; }));
  EXPECT_TRUE(broken([](PoseEstimate& p) { p.ellipse.pan_theta_rad = kNan; }));
}

TEST(Track, KnowsNothingBeforeItsFirstPose) {
  Track track({.focal_px = kFocal_px});
  EXPECT_FALSE(track.has_sighting());
  EXPECT_EQ(track.prior(), nullptr);
  EXPECT_FALSE(track.may_follow_outlines());
}

TEST(Track, ForetellsAllSixFreedomsFromTheLastTwoPoses) {
  Track track({.focal_px = kFocal_px});
  for (int frame = 0; frame < 2; ++frame) {
    PoseCandidate exact = reading(sheet_at(0.30 + 0.02 * frame, 0.01 * frame));
    exact.pose.covariance *= 1e-8;
    taken(track, readings({exact}), MonoTime(1s + frame * 20ms));
  }
  const CameraFromLandmark expected = track.expected_at(MonoTime(1s + 40ms));
  EXPECT_LT(angle_between_rad(expected, sheet_at(0.34)), 1e-9);
  EXPECT_NEAR(expected.translation_m.x(), 0.02, 1e-12);
}

TEST(Track, TakesADifferenceOfTwoPoorlyKnownTiltsForNoise) {
  const auto turn_rad = [](double sigma_rad) {
    Track track({.focal_px = kFocal_px});
    for (int frame = 0; frame < 2; ++frame) {
      PoseCandidate seen = reading(sheet_at(0.3 + 0.1 * frame));
      seen.pose.covariance.bottomRightCorner<3, 3>() = Eigen::Matrix3d::Identity() * sigma_rad * sigma_rad;
      taken(track, readings({seen}), MonoTime(1s + frame * 20ms));
    }
    return angle_between_rad(track.expected_at(MonoTime(1s + 40ms)), sheet_at(0.4));
  };
  EXPECT_NEAR(turn_rad(1e-3), 0.1, 0.001) << "turned by a tenth, and goes on";
  EXPECT_LT(turn_rad(0.1), 0.003) << "it may have turned or not";
}

TEST(Track, FollowsOutlinesOnlyWhileTheyAreForetoldToHalfAPixel) {
  Track track({.focal_px = kFocal_px});
  taken(track, readings({reading(sheet_at(0.3))}), MonoTime(1s));
  EXPECT_TRUE(track.may_follow_outlines()) << "standing still, as far as is known";
  taken(track, readings({reading(sheet_at(0.3, 0.004))}), MonoTime(1s + 20ms));  // 1.4 px from where it was
  EXPECT_FALSE(track.may_follow_outlines());
  taken(track, readings({reading(sheet_at(0.3, 0.008))}), MonoTime(1s + 40ms));  // as foretold
  EXPECT_TRUE(track.may_follow_outlines());
}

TEST(Track, GoesByTheCamerasMotionWhereItHasNoneOfItsOwn) {
  Track track({.focal_px = kFocal_px});
  const SheetMotion motion{{0, 0.5, 0}, {0.3, 0, 0}};
  track.foretell(motion);
  EXPECT_EQ(track.prior(), nullptr) << "nor does it make a pose";
  taken(track, readings({reading(sheet_at(0.30))}), MonoTime(1s));
  track.foretell(motion);
  EXPECT_NEAR(track.expected_at(MonoTime(1s + 20ms)).translation_m.x(), 0.006, 1e-12);
  EXPECT_FALSE(track.motion_at(MonoTime(1s))) << "not what the two last frames say";
  taken(track, readings({reading(sheet_at(0.31, 0.002))}), MonoTime(1s + 20ms));
  track.foretell(motion);
  const CameraFromLandmark expected = track.expected_at(MonoTime(1s + 40ms));
  EXPECT_NEAR(expected.translation_m.x(), 0.004, 1e-12) << "its own way, and what it was off by is no acceleration";
  EXPECT_NEAR(angle_between_rad(expected, sheet_at(0.31)), 0.01, 1e-9) << "turning as the camera does";
}

/// Its rows are exposed 10 ms after the middle one; the first two fits don't know how it moves meanwhile.
TEST(Track, ForetellsTheMiddleRowAlthoughTheFirstFitsKnewNoMotion) {
  constexpr double kSpeed_m_s = 0.5, kRowTime_s = 40e-6, kBelow_m = 0.694444;  // 250 rows at 2 m
  const auto sheet_then = [&](double time_s) {
    CameraFromLandmark T = sheet_at(0.3, kSpeed_m_s * time_s);
    T.translation_m.y() = kBelow_m;
    return T;
  };
  Track track({.focal_px = kFocal_px});
  for (int frame = 0; frame < 4; ++frame) {
    const MonoTime at(1s + frame * 20ms);
    SheetMotion known = track.motion_at(at).value_or(SheetMotion{});
    known.row_time_s = kRowTime_s;
    CameraFromLandmark fitted = sheet_then(0.020 * frame);
    fitted.translation_m.x() += 0.010 * (kSpeed_m_s - known.translation_m_s.x());
    PoseCandidate candidate = reading(fitted);
    candidate.outlines.motion = known;
    taken(track, readings({candidate}), at);
    if (frame == 0) continue;
    const MonoTime next = at + 20ms;
    EXPECT_NEAR(track.motion_at(next)->translation_m_s.x(), kSpeed_m_s, 1e-4) << frame;
    EXPECT_NEAR(track.expected_at(next).translation_m.x(), kSpeed_m_s * 0.020 * (frame + 1), 2e-6) << frame;
  }
}

/// A sheet 2 m away whose direction gains speed from the fourth frame on, its rows exposed after the middle one; as
/// fits have it that take the motion that the track foretold.
class GainingSpeed {
 public:
  GainingSpeed(double gains_1_s2, double frame_s, double rows_s)
      : gains_1_s2_(gains_1_s2), frame_s_(frame_s), rows_s_(rows_s) {}

  void look() {
    const MonoTime at(1s + std::chrono::nanoseconds(std::llround(1e9 * frame_ * frame_s_)));
    SheetMotion known = track.motion_at(at).value_or(SheetMotion{});
    known.row_time_s = kRowTime_s;
    const auto fitted = [&](double x_m) {
      CameraFromLandmark T = sheet_at(0.3, x_m);
      T.translation_m.y() = 2 * rows_s_ / (kFocal_px * kRowTime_s);
      return T;
    };
    const double now_s = frame_ * frame_s_;
    PoseCandidate candidate = reading(fitted(2 * direction(now_s + rows_s_) - rows_s_ * known.translation_m_s.x()));
    candidate.outlines.motion = known;
    taken(track, readings({candidate}), at);
    ++frame_;
  }
  /// How wrong the speed is, by which the rows of the frame that was looked at last are taken to the middle one.
  double speed_error_1_s() const {
    const double now_s = (frame_ - 1) * frame_s_;
    return track.motion_now()->sheet.translation_m_s.x() / 2 -
           (direction(now_s + rows_s_) - direction(now_s)) / rows_s_;
  }

  Track track{{.focal_px = kFocal_px}};

 private:
  static constexpr double kRowTime_s = 40e-6;
  double direction(double t_s) const {
    const double gaining_s = std::max(0.0, t_s - 3 * frame_s_);
    return 0.1 * t_s + gains_1_s2_ * gaining_s * gaining_s / 2;
  }
  double gains_1_s2_, frame_s_, rows_s_;
  int frame_ = 0;
};

/// By 36 px: what is too surprising to go on like that is measured all the same, and known no better than it is.
TEST(Track, MeasuresTheSpeedOfWhatWasForetoldElsewhere) {
  constexpr double kFrame_s = 0.05;
  for (const double rows_s : {-0.007, 0.007}) {
    GainingSpeed sheet(20, kFrame_s, rows_s);
    for (int frame = 0; frame < 9; ++frame) {
      sheet.look();
      if (frame < 5) continue;
      const auto measured = sheet.track.motion_now();
      ASSERT_TRUE(measured && measured->gain) << frame;
      EXPECT_GT(measured->gain->acceleration_1_s2.x(), 15) << frame;
      EXPECT_NEAR(sheet.speed_error_1_s(), 0, kFrame_s * measured->gain->change_1_s2.norm() / 3)
          << frame << ", rows at " << rows_s;
    }
  }
}

TEST(Track, IsSureOfItsNumbersOnceColoursHaveToldThem) {
  Track track({.focal_px = kFocal_px});
  taken(track, readings({reading(sheet_at(0.3))}), MonoTime(1s));
  EXPECT_EQ(track.forecast(MonoTime(1s + 20ms)).numbers, ForecastNumbers::kForetold);
  track.know_numbering();
  EXPECT_EQ(track.forecast(MonoTime(1s + 20ms)).numbers, ForecastNumbers::kCertain);
}

TEST(Track, TakesOtherNumbersForNoMotion) {
  Track track({.focal_px = kFocal_px});
  taken(track, readings({reading(sheet_at(0.3))}), MonoTime(1s));
  taken(track, readings({reading(renumbered(sheet_at(0.3), 2))}), MonoTime(1s + 20ms));
  EXPECT_LT(angle_between_rad(track.expected_at(MonoTime(1s + 40ms)), renumbered(sheet_at(0.3), 2)), 1e-9);
}

TEST(Track, ForetellsADirectionThatGainsSpeed) {
  Track track({.focal_px = kFocal_px});
  const auto aside_m = [](int frame) { return 0.0004 * frame * frame; };  // a third of a pixel more in every frame
  for (int frame = 0; frame < 12; ++frame)
    taken(track, readings({reading(sheet_at(0.3, aside_m(frame)))}), MonoTime(1s + frame * 20ms));
  EXPECT_NEAR(track.expected_at(MonoTime(1s + 240ms)).translation_m.x(), aside_m(12), 0.00002);
  EXPECT_NEAR(track.expected_at(MonoTime(1s + 260ms)).translation_m.x(), aside_m(13), 0.00006) << "two frames ahead";
  EXPECT_NEAR(track.motion_at(MonoTime(1s + 240ms))->translation_m_s.x(), 0.0004 * 2 * 12 / 0.020, 0.002);
}

TEST(Track, ChoosesByThePictureWhereThatCanTellAndByContinuityWhereItCannot) {
  const CameraFromLandmark here = sheet_at(0.3), mirror = sheet_at(-0.3);
  Track track({.focal_px = kFocal_px});
  EXPECT_EQ(taken(track, readings({reading(here), reading(mirror, 4)}), MonoTime(1s)), 0U) << "no track: the picture";
  EXPECT_EQ(taken(track, readings({reading(mirror), reading(here, 4)}), MonoTime(2s)), 1U) << "2 sigma: the track";
  EXPECT_EQ(taken(track, readings({reading(mirror), reading(here, 16)}), MonoTime(3s)), 0U) << "4 sigma: the picture";
}

TEST(Track, NeverChoosesAReadingThatWasNotRefined) {
  const CameraFromLandmark here = sheet_at(0.3), mirror = sheet_at(-0.3);
  Track track({.focal_px = kFocal_px});
  taken(track, readings({reading(here)}), MonoTime(1s));
  PoseCandidate rough = reading(here, 1);
  rough.refined = false;
  EXPECT_EQ(taken(track, readings({reading(mirror), rough}), MonoTime(2s)), 0U);
}

TEST(Track, KeepsTheLosersOdds) {
  Track track({.focal_px = kFocal_px});
  PoseCandidates two = readings({reading(sheet_at(0.3)), reading(sheet_at(-0.3), 4)});
  track.see({});
  ASSERT_TRUE(track.take(two, MonoTime(1s)).has_value());
  const double odds = std::exp(-2.0) / (1 + std::exp(-2.0));
  EXPECT_NEAR(two.list[0].pose.ambiguity, odds, 1e-6);
}

TEST(Track, RefusesFollowedOutlinesWithFewerDotsOrAWorseFit) {
  Track track({.focal_px = kFocal_px});
  taken(track, readings({reading(sheet_at(0.3))}), MonoTime(1s));
  const MonoTime next(1s + 20ms);
  PoseCandidate followed = reading(sheet_at(0.3));
  EXPECT_TRUE(track.expectation(next).includes(followed));
  followed.pose.rms_px = 0.2;
  EXPECT_FALSE(track.expectation(next).includes(followed));
  followed.pose.rms_px = 0.1;
  followed.pose.dots_used = 8;
  EXPECT_FALSE(track.expectation(next).includes(followed));
}

TEST(Track, RefusesFollowedOutlinesThatAreLessCertainOrTurnedInAnyFreedom) {
  Track track({.focal_px = kFocal_px});
  taken(track, readings({reading(sheet_at(0.3))}), MonoTime(1s));
  const MonoTime next(1s + 20ms);
  for (Eigen::Index block : {0, 3}) {
    PoseCandidate unsure = reading(sheet_at(0.3));
    unsure.pose.covariance.block<3, 3>(block, block) *= 16;
    EXPECT_FALSE(track.expectation(next).includes(unsure)) << "four times as uncertain: block " << block;
  }
  EXPECT_TRUE(track.expectation(next).includes(reading(sheet_at(0.32))));
  EXPECT_FALSE(track.expectation(next).includes(reading(sheet_at(0.25)))) << "leaning by 0.05 rad less within a frame";
  CameraFromLandmark rolled_away = sheet_at(0.3);
  rolled_away.rotation = exp_so3({0, 0, 0.05}) * rolled_away.rotation;
  EXPECT_FALSE(track.expectation(next).includes(reading(rolled_away)));
}

/// As a level camera sees the sheet, rolled.
CameraFromLandmark rolled(double roll_deg) {
  CameraFromLandmark T = sheet_at(0.3);
  T.rotation = exp_so3({0, 0, roll_deg * std::numbers::pi / 180}) * T.rotation;
  return T;
}

TEST(Track, KeepsItsNumberingThroughARollAndAMomentOutOfSight) {
  Track track({.focal_px = kFocal_px});
  for (int i = 0; i <= 45; ++i) taken(track, readings({reading(rolled(i))}), MonoTime(1s + i * 20ms));
  EXPECT_FALSE(track.is_numbering_refuted()) << "it began level";
  track.lose_pose(false);
  ASSERT_TRUE(track.remembered(MonoTime(2s + 500ms)).has_value());
  EXPECT_FALSE(track.remembered(MonoTime(3s + 500ms)).has_value()) << "too long ago";
}

TEST(Track, WhatItsWaySaidOfItsNumbersSaysNothingOfALandmarkThatJumpedToOthers) {
  const auto ambiguity = [](Track& track, double roll_deg, MonoTime at) {
    PoseCandidates one = readings({reading(rolled(roll_deg))});
    track.see({});
    EXPECT_TRUE(track.take(one, at).has_value());
    return one.list[0].pose.ambiguity;
  };
  Track track({.focal_px = kFocal_px}), fresh({.focal_px = kFocal_px});
  ambiguity(track, 0, MonoTime(1s));
  EXPECT_LT(ambiguity(track, 19, MonoTime(1s + 20ms)), 1e-3) << "the track was level: it has rolled";
  EXPECT_NEAR(ambiguity(track, -19, MonoTime(1s + 40ms)), ambiguity(fresh, -19, MonoTime(1s)), 1e-9)
      << "by 38 degrees in a frame: no roll";
  EXPECT_GT(ambiguity(fresh, -19, MonoTime(1s)), 1e-3);
}

TEST(Track, EndsWhenItsNumberingWasWrongFromTheStart) {
  // At 25 degrees of roll the neighbouring numbering looks like 20 degrees the other way, and was believed.
  Track track({.focal_px = kFocal_px});
  int refuted_at_deg = 99;
  for (int i = 0; i <= 30 && refuted_at_deg == 99; ++i) {
    taken(track, readings({reading(rolled(-20 - i))}), MonoTime(1s + i * 20ms));
    if (track.is_numbering_refuted()) refuted_at_deg = 25 - i;
  }
  EXPECT_GT(refuted_at_deg, 10);
  EXPECT_LT(refuted_at_deg, 20);
  track.reset();
  EXPECT_FALSE(track.is_numbering_refuted());
  EXPECT_FALSE(track.remembered(MonoTime(1s)).has_value());
}

TEST(Track, APoseOfNoUseEndsIt) {
  Track track({.focal_px = kFocal_px});
  taken(track, readings({reading(sheet_at(0.3))}), MonoTime(1s));
  PoseCandidates broken = readings({reading(sheet_at(0.3))});
  broken.list[0].pose.covariance(2, 2) = 0;
  track.see({});
  const auto chosen = track.take(broken, MonoTime(2s));
  ASSERT_FALSE(chosen.has_value());
  EXPECT_EQ(chosen.error().code, Errc::kPoseDegenerate);
  EXPECT_EQ(track.prior(), nullptr);
  EXPECT_TRUE(track.has_sighting());
}

}  // namespace
}  // namespace ninedot
