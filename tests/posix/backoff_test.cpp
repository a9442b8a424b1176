#include "drivers/posix/backoff.h"

#include <gtest/gtest.h>

#include <csignal>
#include <thread>

#include "drivers/posix/poll_until.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

TEST(Backoff, DoublesFromTheFirstPauseToTheLongest) {
  Backoff backoff(100ms, 500ms);
  EXPECT_EQ(backoff.next(), 100ms);
  EXPECT_EQ(backoff.next(), 200ms);
  EXPECT_EQ(backoff.next(), 400ms);
  EXPECT_EQ(backoff.next(), 500ms);
  EXPECT_EQ(backoff.next(), 500ms);
}

TEST(Backoff, BeginsAnewOnceTheDeviceHasWorked) {
  Backoff backoff(10ms, 1s);
  for (int i = 0; i < 5; ++i) static_cast<void>(backoff.next());
  backoff.reset();
  EXPECT_EQ(backoff.next(), 10ms);
  EXPECT_EQ(backoff.next(), 20ms);
}

TEST(Backoff, APauseLastsItsTimeAndEndsAtOnceWhenRung) {
  const WakeUp wake;
  const MonoTime begun = mono_now();
  EXPECT_FALSE(is_rung_within(wake, 30ms));
  EXPECT_GE(mono_now() - begun, 30ms);
  std::jthread bell([&] {
    std::this_thread::sleep_for(20ms);
    wake.ring();
  });
  EXPECT_TRUE(is_rung_within(wake, 1h));
  EXPECT_TRUE(is_rung_within(wake, 1h)) << "once rung, for ever";
}

TEST(PollUntil, SaysNothingOfDescriptorsWhenItWasInterrupted) {
  struct sigaction ignore {};
  ignore.sa_handler = [](int) {};
  struct sigaction before {};
  ASSERT_EQ(::sigaction(SIGUSR1, &ignore, &before), 0);
  const WakeUp never;
  pollfd polled{never.get(), POLLIN, POLLIN};
  const auto self = ::pthread_self();
  std::jthread sender([&] {
    std::this_thread::sleep_for(20ms);
    ::pthread_kill(self, SIGUSR1);
  });
  EXPECT_EQ(poll_until(std::span(&polled, 1), mono_now() + 1h), -1);
  EXPECT_EQ(polled.revents, 0);
  ::sigaction(SIGUSR1, &before, nullptr);
}

TEST(PollUntil, LooksOnceWhenItsTimeHasPassed) {
  const WakeUp wake;
  pollfd polled{wake.get(), POLLIN, 0};
  EXPECT_EQ(poll_until(std::span(&polled, 1), mono_now() - 1s), 0);
  wake.ring();
  EXPECT_EQ(poll_until(std::span(&polled, 1), mono_now() - 1s), 1);
  EXPECT_NE(polled.revents & POLLIN, 0);
}

}  // namespace
}  // namespace ninedot
