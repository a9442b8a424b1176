#include "aim/servo_axis.h"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace ninedot {
namespace {

constexpr std::array kBent{AxisPoint{-1, 2000}, AxisPoint{0, 1400}, AxisPoint{1, 1000}};

TEST(ServoAxis, MeetsThePointsOfItsCalibrationAndGoesStraightBetweenThem) {
  const ServoAxis unit(kBent, 500, 2500);
  for (const AxisPoint& point : kBent) EXPECT_DOUBLE_EQ(unit.output_at(point.angle_rad).value, point.output);
  EXPECT_DOUBLE_EQ(unit.output_at(0.5).value, 1200);
  EXPECT_DOUBLE_EQ(unit.output_at(1.5).value, 800) << "beyond its end the last piece goes on";
}

TEST(ServoAxis, FindsTheAngleBackFromTheOutput) {
  const ServoAxis unit(kBent, 500, 2500);
  for (double angle_rad = -1.4; angle_rad < 1.4; angle_rad += 0.05)
    EXPECT_NEAR(unit.angle_at(unit.output_at(angle_rad).value), angle_rad, 1e-12);
}

TEST(ServoAxis, CutsAtTheLimitsOfTheOutputAndSaysSo) {
  const ServoAxis unit(kBent, 1000, 1900);
  EXPECT_EQ(unit.output_at(-1).value, 1900);
  EXPECT_TRUE(unit.output_at(-1).limited);
  EXPECT_EQ(unit.output_at(1).value, 1000);
  EXPECT_FALSE(unit.output_at(1).limited);
  EXPECT_TRUE(unit.output_at(1.01).limited);
}

TEST(ServoAxis, AcceptsPointsThatRiseOrFallStrictly) {
  const auto accepts = [](std::vector<AxisPoint> points) { return ServoAxis::accepts(points); };
  EXPECT_TRUE(accepts({{0, 1000}, {1, 2000}}));
  EXPECT_TRUE(accepts({{0, 2000}, {1, 1000}}));
  EXPECT_FALSE(accepts({{0, 1000}}));
  EXPECT_FALSE(accepts({{0, 1000}, {0, 2000}}));
  EXPECT_FALSE(accepts({{0, 1000}, {1, 2000}, {2, 1900}}));
  EXPECT_FALSE(accepts({{0, 1000}, {1, 1000}}));
  std::vector<AxisPoint> many(ServoAxis::kMaxPoints + 1);
  for (std::size_t i = 0; i < many.size(); ++i)
    many[i] = {0.01 * static_cast<double>(i), 1000.0 + static_cast<double>(i)};
  EXPECT_FALSE(accepts(many));
  many.pop_back();
  EXPECT_TRUE(accepts(many));
}

}  // namespace
}  // namespace ninedot
