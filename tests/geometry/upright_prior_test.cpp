#include "geometry/upright_prior.h"

#include <gtest/gtest.h>

#include <cmath>

#include "base/units.h"

namespace ninedot {
namespace {

/// Of a camera straight in front of the sheet and as high, rolled about its optical axis.
NumberingCosts costs_at(double roll_deg, const UprightPrior& prior = {}) {
  const double a = roll_deg * kRadPerDeg;
  return upright_costs({std::cos(a), std::sin(a), 0}, {std::sin(a), -std::cos(a), 0}, {0, 0, -1}, {}, prior);
}

/// [1] that the numbering as printed is the right one.
double odds_of_the_first(const NumberingCosts& costs) {
  double sum = 0;
  for (const double cost : costs) sum += std::exp(-cost / 2);
  return std::exp(-costs[0] / 2) / sum;
}

TEST(UprightPrior, ALevelCameraHasTheNumbersAsPrinted) {
  EXPECT_NEAR(costs_at(0)[0], 0, 0.01);
  EXPECT_GT(odds_of_the_first(costs_at(0)), 0.999);
  EXPECT_GT(odds_of_the_first(costs_at(12)), 0.99);
  EXPECT_NEAR(costs_at(0)[1], costs_at(0)[7], 1e-9) << "an eighth of a turn to either side";
}

TEST(UprightPrior, TheExpectedRollMovesTheMiddle) {
  UprightPrior prior;
  prior.expected_roll_rad = 90 * kRadPerDeg;
  EXPECT_NEAR(costs_at(90, prior)[0], 0, 0.01);
  EXPECT_GT(costs_at(0, prior)[0], 15);
}

TEST(UprightPrior, SaysLittleWhereTheRollIsHardlyKnown) {
  UprightPrior prior;
  prior.roll_sigma_rad = 90 * kRadPerDeg;
  EXPECT_LT(odds_of_the_first(costs_at(0, prior)), 0.2);
}

}  // namespace
}  // namespace ninedot
