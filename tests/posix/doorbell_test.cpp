#include "drivers/posix/doorbell.h"

#include <gtest/gtest.h>

#include <thread>

namespace ninedot {
namespace {

using namespace std::chrono_literals;

TEST(Doorbell, ARingBeforeTheWaitIsNotLostAndCountsOnce) {
  const Doorbell bell;
  EXPECT_FALSE(bell.wait_until(mono_now() - 1s));
  bell.ring();
  bell.ring();
  EXPECT_TRUE(bell.wait_until(mono_now() - 1s));
  EXPECT_FALSE(bell.wait_until(mono_now() + 1ms));
}

TEST(Doorbell, WakesTheOneWhoWaits) {
  const Doorbell bell;
  std::jthread caller([&] {
    std::this_thread::sleep_for(20ms);
    bell.ring();
  });
  const MonoTime begun = mono_now();
  EXPECT_TRUE(bell.wait_until(MonoTime::max()));
  EXPECT_GE(mono_now() - begun, 19ms);
}

TEST(Doorbell, ReturnsAtItsDeadline) {
  const Doorbell bell;
  const MonoTime deadline = mono_now() + 20ms;
  EXPECT_FALSE(bell.wait_until(deadline));
  EXPECT_GE(mono_now(), deadline);
}

}  // namespace
}  // namespace ninedot
