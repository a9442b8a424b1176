// The frame loop must come back in bounded time wherever an ordinary thread was preempted.
#include <gtest/gtest.h>

#include "drivers/camera/reopening_source.h"
#include "tests/support/one_core.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

/// Always has a frame, and nothing to lock. Its description takes long to copy.
class EndlessDevice final : public CameraDevice {
 public:
  void open() override {}
  void close() noexcept override {}
  std::string description() const override { return std::string(1U << 20U, 'x'); }
  std::chrono::nanoseconds frame_period() const noexcept override { return 1s; }
  Result<GrabbedFrame> grab(MonoTime) noexcept override { return GrabbedFrame{}; }
  void release(std::uint32_t) noexcept override {}
};

TEST(OneCore, NextAndGiveBackOfACameraDoNotWaitForAThreadThatReadsItsDescription) {
  const test::OneCore pinned;
  ReopeningSource source(std::make_unique<EndlessDevice>(), {});
  const auto times = test::OneCore::race(
      100, [&] { EXPECT_TRUE(source.next(mono_now())); }, [&] { EXPECT_FALSE(source.description().empty()); });
  if (!times) GTEST_SKIP() << "SCHED_FIFO is not permitted here";
  EXPECT_EQ(times->steps, 100);
  EXPECT_LT(times->longest_step, test::OneCore::kBurst / 2);
  RecordProperty("longest_step_us", static_cast<int>(times->longest_step / 1us));
}

}  // namespace
}  // namespace ninedot
