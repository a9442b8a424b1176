#include "drivers/posix/newest_wins.h"

#include <gtest/gtest.h>

#include <thread>

namespace ninedot {
namespace {

TEST(NewestWins, TellsWhatItReplacedAndHandsItBack) {
  NewestWins place;
  EXPECT_FALSE(place.take());
  EXPECT_EQ(place.put(0, {}), NewestWins::kNone);
  EXPECT_EQ(place.put(1, {.skipped = 2, .flagged = 1}), 0U);
  EXPECT_EQ(place.put(2, {.flagged = 3}), 1U);
  const auto taken = place.take();
  ASSERT_TRUE(taken);
  EXPECT_EQ(taken->buffer, 2U);
  EXPECT_EQ(taken->unseen.skipped, 4U);  // two lost before 1, then 0 and 1 replaced
  EXPECT_EQ(taken->unseen.flagged, 4U);
  EXPECT_FALSE(place.take());
  place.put(3, {});
  EXPECT_EQ(place.take()->unseen.skipped, 0U) << "counted once";
}

TEST(NewestWins, LosesNoBufferAndCountsEachOnceBetweenTwoThreads) {
  constexpr std::uint64_t kPut = 200'000;
  NewestWins place;
  std::atomic<std::uint32_t> free{0xFU};
  std::atomic<bool> is_over{false};
  std::uint64_t seen = 0;
  const auto account = [&](const NewestWins::Taken& taken) {
    seen += 1 + taken.unseen.skipped;
    free.fetch_or(1U << taken.buffer);
  };
  std::jthread taker([&] {
    while (!is_over)
      if (const auto taken = place.take()) account(*taken);
  });
  for (std::uint64_t i = 0; i < kPut; ++i) {
    std::uint32_t mask = free.load();
    while (mask == 0) mask = free.load();
    const auto buffer = static_cast<std::uint32_t>(__builtin_ctz(mask));
    free.fetch_and(~(1U << buffer));
    if (const std::uint32_t older = place.put(buffer, {}); older != NewestWins::kNone) free.fetch_or(1U << older);
  }
  is_over = true;
  taker.join();
  if (const auto last = place.take()) account(*last);
  EXPECT_EQ(seen, kPut);
  EXPECT_EQ(free.load(), 0xFU);
}

}  // namespace
}  // namespace ninedot
