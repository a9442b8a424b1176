#include "detect/work_budget.h"

#include <gtest/gtest.h>

#include <vector>

namespace ninedot {
namespace {

TEST(WorkBudget, GoesRoundFromWhereItEndedAndBeginsAnewOnceItGotThrough) {
  std::size_t begin_at = 0;
  std::vector<std::size_t> tried;
  const auto go = [&](int allowance) {
    return go_round(4, begin_at, [&](std::size_t rank) {
      if (!take_one(allowance)) return false;
      tried.push_back(rank);
      return true;
    });
  };
  EXPECT_EQ(go(3), 3U);
  EXPECT_EQ(begin_at, 3U);
  EXPECT_EQ(go(3), 3U);
  EXPECT_EQ(tried, (std::vector<std::size_t>{0, 1, 2, 3, 0, 1}));
  EXPECT_EQ(begin_at, 2U);
  EXPECT_EQ(go(4), 4U);
  EXPECT_EQ(begin_at, 0U);
}

TEST(WorkBudget, WhatIsTooMuchForOnePictureIsNotTriedForEver) {
  std::size_t begin_at = 2;
  const auto too_much = [](std::size_t) { return false; };
  EXPECT_EQ(go_round(4, begin_at, too_much), 0U);
  EXPECT_EQ(begin_at, 3U);
  EXPECT_EQ(go_round(4, begin_at, too_much), 0U);
  EXPECT_EQ(go_round(4, begin_at, too_much), 0U) << "beyond the last comes the first";
  EXPECT_EQ(begin_at, 1U);
}

TEST(WorkBudget, LetsHalfBeSpentAndKeepsWhatWasNot) {
  int allowance = 9;
  EXPECT_EQ(with_half(allowance,
                      [](int& half) {
                        const int had = half;
                        half -= 3;
                        return had;
                      }),
            5);
  EXPECT_EQ(allowance, 6);
}

TEST(WorkBudget, WhatACrowdedPicturesSearchTakesComesOffThePixelsButNotALandmarks) {
  static constexpr WorkBudget kAllowed;
  const auto pixels = [](int regions, int guesses, int second_guesses) {
    WorkBudget left = kAllowed;
    left.regions -= regions, left.guesses -= guesses, left.second_guesses -= second_guesses;
    return pixels_of_search(kAllowed, left);
  };
  EXPECT_EQ(pixels(0, 0, 0), 0);
  EXPECT_EQ(pixels(400, 10, 0), 0) << "a usual picture";
  EXPECT_GT(pixels(1500, 10, 0), 0);
  EXPECT_GT(pixels(1500, 40, 0), pixels(1500, 10, 0));
  EXPECT_EQ(pixels(1500, 30, 10), pixels(1500, 40, 0));
  const int most = pixels(kAllowed.regions, kAllowed.guesses, kAllowed.second_guesses);
  EXPECT_GE(kAllowed.pixels - most, 10'000);
}

}  // namespace
}  // namespace ninedot
