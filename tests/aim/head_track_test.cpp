#include "aim/head_track.h"

#include <gtest/gtest.h>

namespace ninedot {
namespace {

using namespace std::chrono_literals;
constexpr MonoTime kStart{100s};

TEST(HeadTrack, TurnsEvenlyBetweenItsStamps) {
  HeadTrack track(HeadAngles{0.1, -0.1});
  track.add(kStart, {0.1, -0.1});
  track.add(kStart + 20ms, {0.3, -0.2});
  track.add(kStart + 40ms, {0.3, 0.2});
  EXPECT_NEAR(track.at(kStart + 5ms).pan_rad, 0.15, 1e-12);
  EXPECT_NEAR(track.at(kStart + 5ms).tilt_rad, -0.125, 1e-12);
  EXPECT_NEAR(track.at(kStart + 20ms).pan_rad, 0.3, 1e-12);
  EXPECT_NEAR(track.at(kStart + 30ms).tilt_rad, 0, 1e-12);
  EXPECT_EQ(track.at(kStart + 1s).tilt_rad, 0.2);
}

TEST(HeadTrack, HasAlwaysStoodWhereItWasBeforeItsFirstStamp) {
  HeadTrack track(HeadAngles{0.5, 0});
  EXPECT_EQ(track.at(kStart).pan_rad, 0.5);
  track.add(kStart, {0.9, 0});
  EXPECT_EQ(track.at(kStart - 1ms).pan_rad, 0.5);
  EXPECT_EQ(track.at(kStart).pan_rad, 0.9);
}

TEST(HeadTrack, RemembersLongerThanALoopsDelayAtAHundredStepsASecond) {
  HeadTrack track;
  for (int i = 0; i < 1000; ++i) track.add(kStart + i * 10ms, {0.001 * i, 0});
  EXPECT_NEAR(track.at(kStart + 9500ms).pan_rad, 0.95, 1e-12);
  EXPECT_EQ(track.at(kStart).pan_rad, 0.84) << "the oldest that it remembers";
}

}  // namespace
}  // namespace ninedot
