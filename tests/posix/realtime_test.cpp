#include "drivers/posix/realtime.h"

#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>

#include <cerrno>
#include <csignal>
#include <thread>

#include "base/mono_time.h"
#include "drivers/posix/signals.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

TEST(RealtimeThread, RunsUnderSchedFifoExactlyWhenItSaysSo) {
  Result<void> answer;
  int policy = -1;
  std::thread([&] {
    answer = RealtimeThread(10).enter();
    sched_param parameters{};
    pthread_getschedparam(pthread_self(), &policy, &parameters);
  }).join();
  if (answer)
    EXPECT_EQ(policy, SCHED_FIFO);
  else
    EXPECT_EQ(answer.error().os_errno, EPERM);
}

TEST(RealtimeThread, StaysAnOrdinaryThreadAtPriorityZero) {
  int policy = -1;
  std::thread([&] {
    const Result<void> entered = RealtimeThread(0).enter();
    EXPECT_EQ(entered ? 0 : entered.error().os_errno, ECANCELED);
    sched_param parameters{};
    pthread_getschedparam(pthread_self(), &policy, &parameters);
  }).join();
  EXPECT_EQ(policy, SCHED_OTHER);
}

TEST(RealtimeThread, AnImpossiblePriorityIsRefusedAndNotFatal) {
  std::thread([] {
    const Result<void> entered = RealtimeThread(100).enter();
    EXPECT_EQ(entered ? 0 : entered.error().os_errno, EINVAL);
  }).join();
}

TEST(TerminationSignals, WaitReturnsTheSignalOrZeroInTime) {
  const TerminationSignals signals;
  const MonoTime begin = mono_now();
  EXPECT_EQ(signals.wait(20ms), 0);
  EXPECT_GE(mono_now() - begin, 19ms);
  raise(SIGTERM);
  EXPECT_EQ(signals.wait(1s), SIGTERM);
  raise(SIGPIPE);  // would end this program if it were not ignored
}

}  // namespace
}  // namespace ninedot
