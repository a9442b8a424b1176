#include "drivers/camera/exposure_stamp.h"

#include <gtest/gtest.h>

#include <ctime>

namespace ninedot {
namespace {

using namespace std::chrono_literals;

TEST(ExposureStamp, IsNeverPlausibleWhereNanosecondsHaveNoRoomForIt) {
  EXPECT_EQ(stamp_of(3s, 14us), MonoTime(3s + 14us));
  // 2^63 ns are 9223372036.85 s; the kernel counts on to 2^64.
  EXPECT_EQ(stamp_of(9223372035s, 999999us), MonoTime(9223372035s + 999999us));
  for (const auto& since_boot : {9223372036s, 9223372037s, 18446744073s, -1s})
    EXPECT_EQ(stamp_of(since_boot, 999999us), MonoTime::max());
}

TEST(ExposureStamp, TheMiddleLiesHalfAnExposureAfterItsStartOrBeforeItsEnd) {
  const MonoTime stamp(100ms);
  const ShutterTiming timing{.exposure = 10ms, .readout = 8ms};
  EXPECT_EQ(middle_of_exposure(stamp, StampPoint::kStartOfExposure, timing), MonoTime(105ms));
  EXPECT_EQ(middle_of_exposure(stamp, StampPoint::kEndOfFrame, timing), MonoTime(87ms));
  // One and the same exposure, stamped at its start and at its frame's end.
  EXPECT_EQ(middle_of_exposure(MonoTime(0ms), StampPoint::kStartOfExposure, timing),
            middle_of_exposure(MonoTime(0ms) + timing.exposure + timing.readout, StampPoint::kEndOfFrame, timing));
}

TEST(ExposureStamp, TheFutureAndTheDistantPastAreNotPlausible) {
  const MonoTime now(100s);
  EXPECT_TRUE(is_plausible_stamp(now, now));
  EXPECT_TRUE(is_plausible_stamp(now - 2s, now));
  EXPECT_FALSE(is_plausible_stamp(now + 1ns, now));
  EXPECT_FALSE(is_plausible_stamp(now - 2s - 1ns, now));
  EXPECT_FALSE(is_plausible_stamp(MonoTime::min(), now)) << "a stamp that wrapped";
  EXPECT_FALSE(is_plausible_stamp(MonoTime::max(), now));
}

TEST(ExposureStamp, ASensorStampOfTheBootClockLosesTheTimeInSuspend) {
  const MonoTime now(1000s);
  EXPECT_EQ(monotonic_from_sensor_timestamp(4599980ms, 3600s, now), MonoTime(999980ms));
  EXPECT_EQ(monotonic_from_sensor_timestamp(999980ms, 0s, now), MonoTime(999980ms));
}

TEST(ExposureStamp, ASensorStampThatIsMonotonicAlreadyIsRecognisedByBeingPlausible) {
  const MonoTime now(1000s);
  EXPECT_EQ(monotonic_from_sensor_timestamp(999980ms, 3600s, now), MonoTime(999980ms));
  EXPECT_EQ(monotonic_from_sensor_timestamp(5s, 3600s, now), now) << "neither";
}

TEST(ExposureStamp, TheTimeInSuspendIsTheDifferenceOfTheClocks) {
  timespec boot{}, monotonic{};
  ::clock_gettime(CLOCK_MONOTONIC, &monotonic);
  ::clock_gettime(CLOCK_BOOTTIME, &boot);
  const auto difference =
      std::chrono::seconds(boot.tv_sec - monotonic.tv_sec) + std::chrono::nanoseconds(boot.tv_nsec - monotonic.tv_nsec);
  EXPECT_LT(std::chrono::abs(read_suspended_time() - difference), 50ms);
  EXPECT_GE(read_suspended_time(), 0ns);
}

}  // namespace
}  // namespace ninedot
