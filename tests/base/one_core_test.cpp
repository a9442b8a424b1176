// Who may spin on whom, tried on one processor: an ordinary thread is stopped in the middle of its write by a real-time
// thread that reads. That reader must come back; with a sequence lock it would spin until the kernel takes the
// processor from all real-time threads (sched_rt_runtime_us, 0.95 s of each second), and for ever where it does not.
#include <gtest/gtest.h>
#include <pthread.h>
#include <sched.h>
#include <semaphore.h>

#include <array>
#include <atomic>
#include <cstring>
#include <thread>

#include "base/handoff.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

struct Block {
  std::array<std::uint32_t, 64> words{};
};

/// Lets the reader run while the write is half done.
struct WakeTheReader {
  static inline sem_t reader_may_run{};
  static inline std::atomic<bool> armed{false};
  static inline std::atomic<bool> under_way{false};
  static void in_the_middle() noexcept {
    if (!armed.exchange(false)) return;
    under_way = true;
    sem_post(&reader_may_run);  // with one processor the reader runs now, and this thread when the reader sleeps
    under_way = false;
  }
};

/// While it lives, this thread and those that it starts stay on one processor.
class OneProcessor {
 public:
  OneProcessor() {
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(static_cast<std::size_t>(sched_getcpu()), &one);
    granted = pthread_getaffinity_np(pthread_self(), sizeof before_, &before_) == 0 &&
              pthread_setaffinity_np(pthread_self(), sizeof one, &one) == 0;
  }
  ~OneProcessor() { pthread_setaffinity_np(pthread_self(), sizeof before_, &before_); }
  bool granted = false;

 private:
  cpu_set_t before_{};
};

bool become_realtime() {
  sched_param wanted{};
  wanted.sched_priority = 10;
  return pthread_setschedparam(pthread_self(), SCHED_FIFO, &wanted) == 0;
}

TEST(Handoff, ARealTimeReaderComesBackOnOneProcessorWhileAnOrdinaryWriterStandsInTheMiddleOfItsWrite) {
  const OneProcessor one;
  if (!one.granted) GTEST_SKIP() << "this process may not choose its processor";
  sem_init(&WakeTheReader::reader_may_run, 0, 0);
  Handoff<Block, WakeTheReader> handoff;
  std::atomic<bool> refused{false}, was_under_way{false};
  std::atomic<std::int64_t> took_ns{0};
  Block read;
  sem_t ready;
  sem_init(&ready, 0, 0);
  std::thread reader([&] {  // on the same processor: affinity is inherited
    refused = !become_realtime();
    sem_post(&ready);
    sem_wait(&WakeTheReader::reader_may_run);
    was_under_way = WakeTheReader::under_way.load();
    const MonoTime begin = mono_now();
    read = handoff.take();
    took_ns = (mono_now() - begin).count();
  });
  sem_wait(&ready);
  Block block;
  block.words.fill(1);
  handoff.put(block);
  WakeTheReader::armed = true;
  block.words.fill(2);
  handoff.put(block);
  reader.join();
  if (refused) GTEST_SKIP() << "SCHED_FIFO is refused here: allow it with `ulimit -r`, or run this as root";
  EXPECT_TRUE(was_under_way) << "the reader ran at another time: nothing was proved";
  EXPECT_LT(took_ns, std::chrono::nanoseconds(100ms).count());
  for (const std::uint32_t word : read.words) EXPECT_EQ(word, 1U) << "the newest whole value";
  for (const std::uint32_t word : handoff.take().words) EXPECT_EQ(word, 2U);
}

TEST(Handoff, GivesTheNewestWholeValueToAReaderOfAnotherThread) {
  Handoff<Block> handoff;
  std::atomic<bool> stop{false};
  std::thread writer([&] {
    Block block;
    for (std::uint32_t n = 1; !stop; ++n) {
      block.words.fill(n);
      handoff.put(block);
    }
  });
  std::uint32_t newest = 0;
  for (int i = 0; i < 200000; ++i) {
    const Block& block = handoff.take();
    for (const std::uint32_t word : block.words) ASSERT_EQ(word, block.words[0]);
    ASSERT_GE(block.words[0], newest);
    newest = block.words[0];
  }
  stop = true;
  writer.join();
}

TEST(Handoff, KeepsItsValueUntilThereIsANewerOneAndLosesWhatWasNotTaken) {
  Handoff<int> handoff(5);
  EXPECT_EQ(handoff.take(), 5);
  EXPECT_EQ(handoff.take(), 5);
  handoff.put(6);
  handoff.put(7);
  handoff.put(8);
  EXPECT_EQ(handoff.take(), 8);
  EXPECT_EQ(handoff.take(), 8);
}

}  // namespace
}  // namespace ninedot
