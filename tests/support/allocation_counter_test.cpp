// A counter that misses an allocation lets every test that uses it pass.
#include "tests/support/allocation_counter.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <memory>
#include <opencv2/core.hpp>
#include <thread>
#include <vector>

#include "tests/support/sanitizers.h"

namespace ninedot::test {
namespace {

// Keeps the compiler from leaving out a pair of new and delete.
template <typename T>
void use(T* pointer) {
  asm volatile("" : : "r"(pointer) : "memory");
}

TEST(AllocationGuard, CountsNothingWhereNothingIsAllocated) {
  std::vector<int> numbers(100);
  const AllocationGuard guard;
  for (std::size_t i = 0; i < numbers.size(); ++i) numbers[i] = static_cast<int>(i);
  use(numbers.data());
  EXPECT_EQ(guard.allocations(), 0U);
  EXPECT_EQ(guard.releases(), 0U);
}

TEST(AllocationGuard, CatchesOneNewAndItsDelete) {
  const AllocationGuard guard;
  auto* const number = new int(1);
  use(number);
  delete number;
  EXPECT_EQ(guard.allocations(), 1U);
  EXPECT_EQ(guard.releases(), 1U);
}

TEST(AllocationGuard, CatchesAnOverAlignedNew) {
  struct alignas(64) Line {
    char bytes[64];
  };
  const AllocationGuard guard;
  const auto line = std::make_unique<Line>();
  use(line.get());
  EXPECT_EQ(guard.allocations(), 1U);
}

TEST(AllocationGuard, CatchesEveryRelativeOfMalloc) {
  const AllocationGuard guard;
  void* memory = std::malloc(10);
  use(memory);
  EXPECT_EQ(guard.allocations(), 1U);
  void* const moved = std::realloc(memory, 100000);
  ASSERT_NE(moved, nullptr);
  use(moved);
  std::free(moved);
  EXPECT_GE(guard.allocations(), 2U);
  const auto catches = [&](auto&& allocate) {
    const auto before = guard.allocations();
    void* const got = allocate();
    use(got);
    EXPECT_NE(got, nullptr);
    std::free(got);
    return guard.allocations() == before + 1;
  };
  EXPECT_TRUE(catches([] { return std::calloc(3, 7); }));
#if !NINEDOT_THREAD_SANITIZER  // it has no hook for these two
  EXPECT_TRUE(catches([] { return std::aligned_alloc(64, 128); }));
  EXPECT_TRUE(catches([] {
    void* aligned = nullptr;
    return posix_memalign(&aligned, 64, 128) == 0 ? aligned : nullptr;
  }));
#endif
}

TEST(AllocationGuard, CatchesAMatThatAllocatesInsideOpenCv) {
  cv::Mat ready(8, 8, CV_8UC1);
  const AllocationGuard guard;
  ready.create(8, 8, CV_8UC1);  // the same size: OpenCV keeps what it has
  EXPECT_EQ(guard.allocations(), 0U);
  const cv::Mat other(8, 9, CV_8UC1);
  use(other.data);
  EXPECT_GE(guard.allocations(), 1U);
}

TEST(AllocationGuard, CountsItsOwnThreadAlone) {
  std::atomic<bool> armed{false}, done{false};
  std::uint64_t allocations_there = 0;
  std::thread other([&] {
    while (!armed) std::this_thread::yield();
    const AllocationGuard guard_there;
    use(std::make_unique<int>(1).get());
    allocations_there = guard_there.allocations();
    done = true;
  });
  std::uint64_t allocations_here = 1;
  {
    const AllocationGuard guard;
    armed = true;
    while (!done) std::this_thread::yield();
    allocations_here = guard.allocations();
  }
  other.join();
  EXPECT_EQ(allocations_here, 0U);
  EXPECT_EQ(allocations_there, 1U);
}

TEST(AllocationGuard, CountsForItselfWhenNested) {
  const AllocationGuard outer;
  use(std::make_unique<int>(1).get());
  const AllocationGuard inner;
  use(std::make_unique<int>(2).get());
  EXPECT_EQ(inner.allocations(), 1U);
  EXPECT_EQ(outer.allocations(), 2U);
}

}  // namespace
}  // namespace ninedot::test
