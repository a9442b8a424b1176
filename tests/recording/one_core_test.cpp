// The frame loop must come back in bounded time wherever the decoding thread was preempted.
#include <gtest/gtest.h>

#include <thread>

#include "drivers/recording/recording_source.h"
#include "tests/recording/temporary_recording.h"
#include "tests/support/one_core.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

TEST(OneCore, NextAndGiveBackOfARecordingDoNotWaitForTheDecodingThread) {
  const TemporaryRecording recording(5);
  const test::OneCore pinned;
  // So many frames a second that the thread is at it without a pause.
  RecordingSource source(recording.path(), {.pace = RecordingPace::kRealTime, .rate_hz = 1e6, .loop = true});
  int taken = 0;
  const auto take = [&] {
    if (source.next(mono_now())) ++taken;
  };
  const auto times = test::OneCore::race(1000, take, [] { std::this_thread::sleep_for(1ms); });
  if (!times) GTEST_SKIP() << "SCHED_FIFO is not permitted here";
  EXPECT_GT(taken, 0);
  EXPECT_LT(times->longest_step, test::OneCore::kBurst / 2);
  RecordProperty("longest_step_us", static_cast<int>(times->longest_step / 1us));
}

}  // namespace
}  // namespace ninedot
