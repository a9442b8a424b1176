// Pictures of a head that goes from stop to stop: what counts as one, and what it shows.
#include "calibrate_head/head_stops.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/units.h"
#include "calibrate_head/head_sufficiency.h"
#include "tests/calibrate_head/made_up_head.h"

namespace ninedot {
namespace {

constexpr double kNoise_px = 0.02;
constexpr std::chrono::milliseconds kPeriod{30};

/// A landmark straight ahead in a metre, seen at an angle to the side.
CameraFromLandmark at_angle(double angle_rad) {
  Eigen::Matrix3d facing;
  facing << -1, 0, 0, 0, 0, -1, 0, -1, 0;
  return {facing, {std::sin(angle_rad), 0, std::cos(angle_rad)}};
}

class Film {
 public:
  /// \param pictures  at this place \param seen_rad  where the landmark is; not a number: nowhere
  void stand(const HeadAngles& told, int pictures, double seen_rad = 0.1, double drift_rad = 0) {
    for (int i = 0; i < pictures; ++i) {
      HeadFrame frame{0, MonoTime(kPeriod * ++count_), told, {}};
      if (std::isfinite(seen_rad))
        frame.seen.push_back(test::made_up_sighting(at_angle(seen_rad + i * drift_rad), kNoise_px, ++seed_));
      frames.push_back(frame);
    }
  }
  void turn(const HeadAngles& from, const HeadAngles& to, int pictures = 5) {
    for (int i = 1; i < pictures; ++i) {
      const double part = static_cast<double>(i) / pictures;
      stand({from.pan_rad + part * (to.pan_rad - from.pan_rad), from.tilt_rad + part * (to.tilt_rad - from.tilt_rad)},
            1, 0.3 * part);
    }
  }
  std::vector<HeadFrame> frames;

 private:
  int count_ = 0;
  std::uint64_t seed_ = 0;
};

constexpr HeadAngles kA{0.1, 0}, kB{0.2, 0}, kC{0.15, 0.1};

TEST(HeadStops, AreWhereTheToldAnglesStayAndWithTheSidesTheyCameFrom) {
  Film film;
  film.stand(kA, 20);
  film.turn(kA, kB);
  film.stand(kB, 20);
  film.turn(kB, kC);
  film.stand(kC, 20);
  const FoundStops found = find_stops(film.frames);
  ASSERT_EQ(found.stops.size(), 3U);
  EXPECT_EQ(found.stops[0].pan_side, 0) << "nobody saw where it came from";
  EXPECT_EQ(found.stops[1].pan_side, 1);
  EXPECT_EQ(found.stops[1].tilt_side, 0);
  EXPECT_EQ(found.stops[2].pan_side, -1);
  EXPECT_EQ(found.stops[2].tilt_side, 1);
  EXPECT_NEAR(found.stops[1].told.pan_rad, 0.2, 1e-12);
  EXPECT_EQ(found.unsteady + found.without_landmark, 0U);
  EXPECT_NEAR(found.told_max.pan_rad, 0.2, 1e-12);
}

/// Three pictures that show where it stands, and two of its first step away, which is not told to be another angle yet.
TEST(HeadStops, EndWhereTheHeadSetsOff) {
  Film film;
  film.stand(kA, 13);
  film.stand({kA.pan_rad + 0.04 * kRadPerDeg, 0}, 2, 0.1 + 0.0025);
  film.turn(kA, kB);
  film.stand(kB, 20);
  const FoundStops found = find_stops(film.frames);
  EXPECT_EQ(found.unsteady, 0U);
  ASSERT_EQ(found.stops.size(), 2U);
  EXPECT_EQ(found.stops[0].told.pan_rad, kA.pan_rad);
}

TEST(HeadStops, AverageTheirPicturesAndSayWhatThatIsWorth) {
  Film film;
  film.stand(kA, 60);
  const FoundStops found = find_stops(film.frames);
  ASSERT_EQ(found.stops.size(), 1U);
  ASSERT_EQ(found.stops[0].seen.size(), 1U);
  const LandmarkSighting& mean = found.stops[0].seen[0];
  const LandmarkSighting exact = test::made_up_sighting(at_angle(0.1), 0, 1);
  const double one = test::made_up_sighting(at_angle(0.1), kNoise_px, 1).dots[0].information(0, 0);
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    EXPECT_LT((mean.dots[dot].ray - exact.dots[dot].ray).norm(), 0.5 * kNoise_px / test::kMadeUpFocalLength_px);
    // Half of a picture's variance is taken to be the next one's as well: never worth more than two.
    EXPECT_GT(mean.dots[dot].information(0, 0), 1.8 * one);
    EXPECT_LT(mean.dots[dot].information(0, 0), 2 * one);
  }
}

TEST(HeadStops, LeaveOutPicturesFromBeforeTheHeadHasComeToRest) {
  Film film;
  film.stand(kA, 10, 0.1, 0.004);  // it still turns, though it was told to have arrived
  film.stand(kA, 20, 0.14);
  const FoundStops found = find_stops(film.frames);
  ASSERT_EQ(found.stops.size(), 1U);
  EXPECT_NEAR(found.stops[0].seen[0].dots[kCentreDot].ray.x(), std::tan(0.14), 1e-4);
}

TEST(HeadStops, AreNoneWhereItHardlyStood) {
  Film film;
  film.stand(kA, 10);  // 0.27 s: a servo may not even have begun to turn
  film.stand(kB, 20);
  EXPECT_EQ(find_stops(film.frames).stops.size(), 1U);
}

TEST(HeadStops, AreNoneWhereTheLandmarkMoves) {
  Film film;
  for (const HeadAngles& at : {kA, kB, kC}) film.stand(at, 25, 0.1, 0.002);
  const FoundStops found = find_stops(film.frames);
  EXPECT_TRUE(found.stops.empty());
  EXPECT_EQ(found.unsteady, 3U);
  ASSERT_EQ(what_stops_lack(found).size(), 1U);
  EXPECT_NE(what_stops_lack(found)[0].find("the landmark moved while the head stood, at 3 of 3 stops"),
            std::string::npos)
      << what_stops_lack(found)[0];
}

TEST(HeadStops, OutvoteAPictureThatIsNumberedOtherwise) {
  Film film;
  film.stand(kA, 25);
  for (const std::size_t picture : {15U, 18U}) {
    LandmarkSighting& seen = film.frames[picture].seen[0];
    seen.dots = renumbered(seen.dots, 1);
  }
  const FoundStops found = find_stops(film.frames);
  ASSERT_EQ(found.stops.size(), 1U);
  const LandmarkSighting exact = test::made_up_sighting(at_angle(0.1), 0, 1);
  EXPECT_LT((found.stops[0].seen[0].dots[0].ray - exact.dots[0].ray).norm(), 1e-4);
}

TEST(HeadStops, OfTwoRecordingsAreApart) {
  Film film;
  film.stand(kA, 20);
  film.stand(kA, 20);
  for (std::size_t i = 20; i < 40; ++i) film.frames[i].recording = 1;
  const FoundStops found = find_stops(film.frames);
  ASSERT_EQ(found.stops.size(), 2U);
  EXPECT_EQ(found.stops[1].recording, 1U);
}

/// Stops at these told angles [deg], each with a landmark.
FoundStops stops_over(double pan_deg, double tilt_deg, std::size_t count) {
  FoundStops found;
  for (std::size_t i = 0; i < count; ++i) {
    const double part = count > 1 ? static_cast<double>(i) / static_cast<double>(count - 1) : 0;
    found.stops.push_back({0, {part * pan_deg * kRadPerDeg, part * tilt_deg * kRadPerDeg}, 0, 0, {}});
  }
  found.told_max = {pan_deg * kRadPerDeg, tilt_deg * kRadPerDeg};
  return found;
}

std::string lack_of(const FoundStops& found) {
  std::string all;
  for (const std::string& lack : what_stops_lack(found)) all += (all.empty() ? "" : "; ") + lack;
  return all;
}

TEST(HeadSufficiency, SaysAllThatIsMissing) {
  EXPECT_EQ(lack_of(stops_over(30, 25, 20)), "");
  EXPECT_EQ(lack_of(stops_over(30, 3, 20)), "the tilt axis moved by 3 degrees: move it by 20 at least");
  EXPECT_EQ(lack_of(stops_over(5, 3, 7)),
            "the pan axis moved by 5 degrees: move it by 20 at least; the tilt axis moved by 3 degrees: move it by 20 "
            "at least; 7 stops with a landmark in sight are too few: make 12 at least, 40 or more are good");
  FoundStops blind = stops_over(30, 25, 20);
  blind.without_landmark = blind.stops.size();
  blind.stops.clear();
  EXPECT_EQ(lack_of(blind).substr(0, 45), "no landmark in sight at any of 20 stops: poin");
  FoundStops lost = stops_over(30, 3, 20);
  lost.told_max.tilt_rad = 0.6;
  EXPECT_NE(lack_of(lost).find("by 3 degrees with a landmark in sight: move it by 20 at least; a landmark that is "
                               "farther away"),
            std::string::npos)
      << lack_of(lost);
  EXPECT_EQ(lack_of(FoundStops{}).substr(0, 36), "no angles of a head that moves: fram");
  FoundStops restless;
  restless.told_max = {1, 1};
  EXPECT_EQ(lack_of(restless), "the head never stood: let it stand for a second at each stop");
}

TEST(HeadSufficiency, RefusesNumbersThatAreTooUncertain) {
  HeadCalibration head;
  head.stops = 30;
  head.pan.points = head.tilt.points = {{-0.3, -0.3, 1e-3}, {0.3, 0.3, 1e-3}};
  EXPECT_TRUE(what_head_lacks(head).empty());
  head.camera_sigma_m.y() = 0.03;
  ASSERT_EQ(what_head_lacks(head).size(), 1U);
  EXPECT_EQ(what_head_lacks(head)[0].substr(0, 32), "lengths are uncertain by 30 mm: ");
  head.tilt.points[1].sigma_rad = 0.02;
  EXPECT_EQ(what_head_lacks(head).size(), 2U);
  head.left_out = 11;
  ASSERT_EQ(what_head_lacks(head).size(), 1U);
  EXPECT_EQ(what_head_lacks(head)[0].substr(0, 39), "11 of 41 stops contradict the others: w");
  head.left_out = 0, head.stops = 11;
  EXPECT_EQ(what_head_lacks(head).size(), 1U);
}

TEST(HeadSufficiency, RefusesAnAxisThatTurnsBack) {
  HeadCalibration head;
  head.stops = 30;
  head.pan.points = head.tilt.points = {{-0.3, -0.3, 1e-3}, {0, 0.1, 1e-3}, {0.3, 0.05, 1e-3}};
  EXPECT_EQ(what_head_lacks(head).size(), 2U);
}

}  // namespace
}  // namespace ninedot
