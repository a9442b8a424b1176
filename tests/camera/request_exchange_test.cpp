#include "drivers/camera/request_exchange.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "tests/support/allocation_counter.h"
#include "tests/support/one_core.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

/// In libcamera's place: allocates, and takes a lock, whenever a request is queued.
struct AllocatingCamera {
  std::mutex mutex;
  std::vector<std::unique_ptr<std::string>> messages;
  std::thread::id thread;
  std::atomic<int> queued{0};

  void queue(std::uint32_t request) {
    const std::lock_guard lock(mutex);
    messages.push_back(std::make_unique<std::string>(100, static_cast<char>('0' + request)));
    if (messages.size() > 100) messages.clear();
    thread = std::this_thread::get_id();
    ++queued;
  }
  bool has_queued(int count) const {
    for (const MonoTime give_up = mono_now() + 5s; mono_now() < give_up && queued < count;)
      std::this_thread::sleep_for(1ms);
    return queued == count;
  }
};

TEST(RequestExchange, TheNewestWinsTheOthersAreQueuedAgainAndEachIsCounted) {
  AllocatingCamera camera;
  RequestExchange exchange([&](std::uint32_t request) { camera.queue(request); });
  EXPECT_EQ(exchange.take(mono_now()).error().code, Errc::kNoFrame);
  exchange.complete(0);
  exchange.complete_damaged(1);
  exchange.complete(2);
  exchange.complete(3);
  const auto taken = exchange.take(mono_now());
  ASSERT_TRUE(taken);
  EXPECT_EQ(taken->buffer, 3U);
  EXPECT_EQ(taken->unseen.skipped, 2U);
  EXPECT_EQ(taken->unseen.flagged, 1U);
  EXPECT_TRUE(camera.has_queued(3));
  exchange.give_back(taken->buffer);
  EXPECT_TRUE(camera.has_queued(4));
}

TEST(RequestExchange, QueueingAgainAllocatesInAThreadOfItsOwnAndNeverInTheOneThatGivesBack) {
  AllocatingCamera camera;
  RequestExchange exchange([&](std::uint32_t request) { camera.queue(request); });
  const test::AllocationGuard guard;
  for (std::uint32_t i = 0; i < 100; ++i) {
    exchange.complete(i % 4);
    const auto taken = exchange.take(mono_now() + 1s);
    ASSERT_TRUE(taken);
    exchange.give_back(taken->buffer);
    while (camera.queued <= static_cast<int>(i)) std::this_thread::yield();
  }
  EXPECT_EQ(guard.allocations(), 0U);
  EXPECT_EQ(guard.releases(), 0U);
  EXPECT_NE(camera.thread, std::this_thread::get_id());
}

TEST(RequestExchange, ALossWakesTheOneWhoWaitsAndStays) {
  RequestExchange exchange([](std::uint32_t) {});
  std::jthread camera([&] {
    std::this_thread::sleep_for(20ms);
    exchange.lose("the camera is gone");
  });
  const MonoTime begun = mono_now();
  const auto lost = exchange.take(begun + 10s);
  ASSERT_FALSE(lost);
  EXPECT_EQ(lost.error().code, Errc::kCameraLost);
  EXPECT_EQ(lost.error().os_errno, ENODEV);
  EXPECT_LT(mono_now() - begun, 5s);
  exchange.complete(0);
  EXPECT_FALSE(exchange.take(begun));
}

TEST(RequestExchange, NothingIsQueuedAgainOnceItIsStopped) {
  AllocatingCamera camera;
  RequestExchange exchange([&](std::uint32_t request) { camera.queue(request); });
  exchange.stop();
  exchange.give_back(1);
  std::this_thread::sleep_for(20ms);
  EXPECT_EQ(camera.queued, 0);
}

TEST(OneCore, TakingAndGivingBackDoesNotWaitForAThreadThatQueuesOrCompletes) {
  const test::OneCore pinned;
  AllocatingCamera camera;
  std::atomic<std::uint32_t> with_camera{0xFU};  // a bit each
  RequestExchange exchange([&](std::uint32_t request) {
    camera.queue(request);
    with_camera.fetch_or(1U << request);
  });
  int taken = 0;
  const auto times = test::OneCore::race(
      500,
      [&] {
        if (const auto newest = exchange.take(mono_now())) exchange.give_back(newest->buffer), ++taken;
      },
      [&] {
        for (std::uint32_t request = 0; request < 4; ++request)
          if ((with_camera.fetch_and(~(1U << request)) & 1U << request) != 0) exchange.complete(request);
        std::this_thread::yield();
      });
  if (!times) GTEST_SKIP() << "SCHED_FIFO is not permitted here";
  EXPECT_GT(taken, 0);
  EXPECT_LT(times->longest_step, test::OneCore::kBurst / 2);
}

}  // namespace
}  // namespace ninedot
