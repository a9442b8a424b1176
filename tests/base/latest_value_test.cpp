#include "base/latest_value.h"

#include <gtest/gtest.h>

#include <array>
#include <thread>

namespace ninedot {
namespace {

struct Block {
  std::array<std::uint32_t, 301> words{};
};

TEST(LatestValue, ReadersNeverSeeAMixtureOfTwoPublishedValues) {
  LatestValue<Block> mailbox;
  std::atomic<bool> stop{false};
  std::thread writer([&] {
    Block block;
    for (std::uint32_t n = 1; !stop; ++n) {
      block.words.fill(n);
      mailbox.publish(block);
      std::this_thread::sleep_for(std::chrono::microseconds(20));
    }
  });
  std::uint32_t newest = 0;
  for (int i = 0; i < 100000; ++i) {
    const Block block = mailbox.read();
    for (const std::uint32_t word : block.words) ASSERT_EQ(word, block.words[0]);
    ASSERT_GE(block.words[0], newest);
    newest = block.words[0];
  }
  stop = true;
  writer.join();
}

TEST(LatestValue, VersionCountsPublications) {
  LatestValue<int> mailbox(5);
  EXPECT_EQ(mailbox.read(), 5);
  EXPECT_EQ(mailbox.version(), 0U);
  mailbox.publish(7);
  EXPECT_EQ(mailbox.read(), 7);
  EXPECT_EQ(mailbox.version(), 1U);
}

}  // namespace
}  // namespace ninedot
