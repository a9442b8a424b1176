#include "base/object_handoff.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>

namespace ninedot {
namespace {

struct Counted {
  explicit Counted(int n) : number(n) { ++alive; }
  ~Counted() { --alive; }
  Counted(const Counted&) = delete;
  Counted& operator=(const Counted&) = delete;
  int number;
  static inline std::atomic<int> alive{0};
};

using Handoff = ObjectHandoff<Counted>;

TEST(ObjectHandoff, GivesTheNewestOnceAndFreesWhatNobodyTook) {
  {
    Handoff handoff;
    EXPECT_EQ(handoff.take(), nullptr);
    handoff.put(std::make_unique<Counted>(1));
    handoff.put(std::make_unique<Counted>(2));
    EXPECT_EQ(Counted::alive, 1);
    const auto taken = handoff.take();
    ASSERT_NE(taken, nullptr);
    EXPECT_EQ(taken->number, 2);
    EXPECT_EQ(handoff.take(), nullptr);
    handoff.put(std::make_unique<Counted>(3));
  }
  EXPECT_EQ(Counted::alive, 0) << "also what lay there in the end";
}

TEST(ObjectHandoff, TakesNothingFurtherUntilWhatWasGivenBackIsFreed) {
  Handoff handoff;
  handoff.put(std::make_unique<Counted>(1));
  handoff.give_back(handoff.take());
  EXPECT_EQ(Counted::alive, 1) << "not by the taker";
  handoff.free_returned();
  EXPECT_EQ(Counted::alive, 0);
  handoff.put(std::make_unique<Counted>(2));
  handoff.give_back(handoff.take());
  handoff.put(std::make_unique<Counted>(3));
  EXPECT_EQ(Counted::alive, 1) << "putting frees as well";
  EXPECT_EQ(handoff.take()->number, 3);
}

TEST(ObjectHandoff, ATakerThatGivesBackWithoutHavingTakenIsABug) {
  Handoff handoff;
  handoff.give_back(std::make_unique<Counted>(1));
  EXPECT_DEATH(handoff.give_back(std::make_unique<Counted>(2)), "");
}

TEST(ObjectHandoff, LosesNoneBetweenTwoThreads) {
  constexpr int kObjects = 20'000;
  {
    Handoff handoff;
    std::atomic<bool> is_over{false};
    std::thread taker([&] {
      auto current = std::make_unique<Counted>(0);
      while (!is_over || current->number < kObjects) {
        auto fresh = handoff.take();
        if (fresh == nullptr) continue;
        EXPECT_GT(fresh->number, current->number);
        std::swap(fresh, current);
        handoff.give_back(std::move(fresh));
      }
    });
    for (int i = 1; i <= kObjects; ++i) handoff.put(std::make_unique<Counted>(i));
    is_over = true;
    while (Counted::alive > 1) handoff.free_returned(), std::this_thread::yield();
    taker.join();
  }
  EXPECT_EQ(Counted::alive, 0);
}

}  // namespace
}  // namespace ninedot
