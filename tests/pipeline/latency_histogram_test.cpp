#include "pipeline/latency_histogram.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace ninedot {
namespace {

using namespace std::chrono_literals;

TEST(LatencyHistogram, AnswersZeroWhileEmpty) {
  const LatencyHistogram histogram;
  EXPECT_EQ(histogram.quantile(0.5), 0ns);
  EXPECT_EQ(histogram.max(), 0ns);
}

TEST(LatencyHistogram, QuantilesAreWithinTheStatedErrorOfTheSortedValues) {
  std::mt19937_64 random(20120578);
  std::lognormal_distribution<double> latency_us(8, 2);  // from about 10 us to seconds
  LatencyHistogram histogram;
  std::vector<std::chrono::nanoseconds> values;
  for (int i = 0; i < 20000; ++i) {
    values.emplace_back(static_cast<std::int64_t>(1000 * latency_us(random)));
    histogram.add(values.back());
  }
  std::sort(values.begin(), values.end());
  for (const double fraction : {0.0, 0.01, 0.25, 0.5, 0.9, 0.99, 0.999, 1.0}) {
    const auto rank = static_cast<std::size_t>(std::max(1.0, std::ceil(fraction * 20000)));
    const auto exact = values[rank - 1];
    const auto answer = histogram.quantile(fraction);
    EXPECT_GE(answer + 1us, exact) << fraction;
    EXPECT_LE(static_cast<double>((answer - 1us).count()),
              static_cast<double>(exact.count()) * (1 + LatencyHistogram::kMaxRelativeError))
        << fraction;
  }
  EXPECT_EQ(histogram.max(), values.back());
  EXPECT_EQ(histogram.count(), 20000U);
}

TEST(LatencyHistogram, QuantilesNeverFallAsTheFractionRises) {
  std::mt19937_64 random(7);
  std::uniform_int_distribution<std::int64_t> bits(0, 40);
  LatencyHistogram histogram;
  for (int i = 0; i < 5000; ++i) histogram.add(std::chrono::nanoseconds(std::int64_t{1} << bits(random)));
  auto before = 0ns;
  for (int percent = 0; percent <= 100; ++percent) {
    const auto now = histogram.quantile(percent / 100.0);
    EXPECT_GE(now, before);
    before = now;
  }
}

TEST(LatencyHistogram, AQuantileIsTheSmallestValueThatAtLeastSoManyReach) {
  LatencyHistogram histogram;
  for (const auto value : {10us, 20us, 30us, 40us, 50us}) histogram.add(value);
  EXPECT_EQ(histogram.quantile(0.5), 31us) << "two of five are less than half of them";
  EXPECT_EQ(histogram.quantile(0.61), 41us);
  EXPECT_EQ(histogram.quantile(0.2), 11us);
}

TEST(LatencyHistogram, NoQuantileIsAboveTheLargestValue) {
  for (const auto largest : {700us, 5001us, 123456us}) {
    LatencyHistogram histogram;
    histogram.add(largest);
    EXPECT_EQ(histogram.quantile(1.0), largest) << "not its bucket's edge";
  }
}

TEST(LatencyHistogram, IsExactToTheMicrosecondBelow64) {
  for (std::int64_t us = 0; us < 64; ++us) {
    LatencyHistogram histogram;
    histogram.add(std::chrono::microseconds(us));
    histogram.add(10s);
    EXPECT_EQ(histogram.quantile(0.5), std::chrono::microseconds(us + 1));
  }
}

TEST(LatencyHistogram, CountsNegativeValuesAsZeroAndVeryLongOnesAsTheLongest) {
  LatencyHistogram histogram;
  histogram.add(-5s);
  histogram.add(100h);
  EXPECT_LE(histogram.quantile(0.5), 1us);
  EXPECT_EQ(histogram.max(), 100h);
  EXPECT_GE(histogram.quantile(1), LatencyHistogram::kLongest);
}

}  // namespace
}  // namespace ninedot
