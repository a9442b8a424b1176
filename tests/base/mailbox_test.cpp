#include "base/mailbox.h"

#include <gtest/gtest.h>

#include <array>
#include <thread>

namespace ninedot {
namespace {

using namespace std::chrono_literals;

struct Block {
  std::array<std::uint32_t, 301> words{};
};

TEST(Mailbox, ReadersNeverSeeAMixtureOfTwoPublishedValues) {
  Mailbox<Block> mailbox;
  std::atomic<bool> stop{false};
  std::thread writer([&] {
    Block block;
    for (std::uint32_t n = 1; !stop; ++n) {
      block.words.fill(n);
      mailbox.publish(block);
      std::this_thread::sleep_for(std::chrono::microseconds(20));
    }
  });
  std::uint64_t newest = 0;
  for (int i = 0; i < 100000; ++i) {
    const auto [block, version] = mailbox.read_with_version();
    for (const std::uint32_t word : block.words) ASSERT_EQ(word, block.words[0]);
    ASSERT_EQ(block.words[0], version);
    ASSERT_GE(version, newest);
    newest = version;
  }
  stop = true;
  writer.join();
}

TEST(Mailbox, VersionCountsPublications) {
  Mailbox<int> mailbox(5);
  EXPECT_EQ(mailbox.read(), 5);
  EXPECT_EQ(mailbox.version(), 0U);
  mailbox.publish(7);
  EXPECT_EQ(mailbox.read(), 7);
  EXPECT_EQ(mailbox.version(), 1U);
}

TEST(Mailbox, WaitingEndsAtOnceWhereANewerValueIsThereAlready) {
  Mailbox<int> mailbox;
  mailbox.publish(1);
  const MonoTime begin = mono_now();
  EXPECT_EQ(mailbox.wait_newer(0, begin + 10s), 1U);
  EXPECT_LT(mono_now() - begin, 1s);
}

TEST(Mailbox, WaitingEndsAtItsDeadlineAndNotBefore) {
  const Mailbox<int> mailbox;
  const MonoTime deadline = mono_now() + 20ms;
  EXPECT_EQ(mailbox.wait_newer(0, deadline), 0U);
  EXPECT_GE(mono_now(), deadline);
  EXPECT_LT(mono_now(), deadline + 5s);
}

TEST(Mailbox, EveryWaitingReaderIsWokenByEveryPublicationItSleepsThrough) {
  constexpr std::uint64_t kLast = 2000;
  Mailbox<std::uint64_t> mailbox;
  std::atomic<int> late{0};
  const auto follow = [&] {
    for (std::uint64_t seen = 0; seen < kLast;) {
      const MonoTime begin = mono_now();
      seen = mailbox.wait_newer(seen, begin + 3s);
      if (mono_now() - begin < 3s) continue;
      ++late;  // slept through publications
      return;
    }
  };
  std::thread first(follow), second(follow), third(follow);
  for (std::uint64_t n = 1; n <= kLast; ++n) {
    mailbox.publish(n);
    if (n % 4 == 0) std::this_thread::sleep_for(50us);
  }
  first.join(), second.join(), third.join();
  EXPECT_EQ(late, 0);
}

}  // namespace
}  // namespace ninedot
