#include "drawing/map_plan.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace ninedot {
namespace {

/// Two sheets on a wall 4 m long that looks along +Y, the second one uncertain by 3 mm along X and 1 mm along Y.
std::vector<MappedLandmark> two() {
  std::vector<MappedLandmark> landmarks{{1, "", place_upright({0, 0, 1.5}, 0)},
                                        {12, "", place_upright({4, 0, 1.5}, 0)}};
  landmarks[1].covariance.diagonal() << 9e-6, 1e-6, 1e-6, 0, 0, 0;
  return landmarks;
}

double number_after(const std::string& text, const std::string& words) {
  const std::size_t at = text.find(words);
  return at == std::string::npos ? -1 : std::stod(text.substr(at + words.size()));
}

TEST(MapPlan, StatesByHowMuchItsEllipsesAreEnlarged) {
  const std::string svg = draw_map_plan(two(), 1);
  const double times = number_after(svg, "ellipses: 1-sigma, ");
  ASSERT_GT(times, 0) << svg;
  // The page is 297 mm wide with margins of 14 mm for 4 m and half a metre at each end.
  const double mm_per_m = (297 - 28) / 5.0;
  EXPECT_NEAR(number_after(svg, "<ellipse rx=\""), 0.003 * times * mm_per_m, 0.01);
  EXPECT_NEAR(number_after(svg, "ry=\""), 0.001 * times * mm_per_m, 0.01);
  EXPECT_EQ(svg.find("<ellipse"), svg.rfind("<ellipse")) << "the origin has none";
}

TEST(MapPlan, TurnsEllipsesAsTheWorldIsSeenFromAbove) {
  std::vector<MappedLandmark> landmarks = two();
  landmarks[1].covariance(0, 1) = landmarks[1].covariance(1, 0) = 2e-6;  // long from X towards Y
  const double turn_deg = number_after(draw_map_plan(landmarks, 1).substr(1), "rotate(");
  EXPECT_LT(turn_deg, -5) << "the page's y goes down, and so do its angles";
  EXPECT_GT(turn_deg, -45);
}

TEST(MapPlan, HasANumberForEachLandmarkAndABarOfAKnownLength) {
  const std::string svg = draw_map_plan(two(), 1);
  EXPECT_NE(svg.find(">12</text>"), std::string::npos);
  EXPECT_NE(svg.find(">1</text>"), std::string::npos);
  EXPECT_NE(svg.find(">1 m</text>"), std::string::npos) << svg;
}

TEST(MapPlan, DrawsALoneExactLandmark) {
  const std::string svg = draw_map_plan(std::vector<MappedLandmark>{two()[0]}, 1);
  EXPECT_EQ(svg.find("ellipse"), std::string::npos);
  EXPECT_EQ(svg.find("\"nan"), std::string::npos);
  EXPECT_EQ(svg.find("\"inf"), std::string::npos);
}

}  // namespace
}  // namespace ninedot
