#include "drawing/calibration_picture.h"

#include <gtest/gtest.h>

#include <limits>

namespace ninedot {
namespace {

std::size_t count(const std::string& text, const std::string& part) {
  std::size_t found = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
  return found;
}

TEST(CalibrationPicture, DrawsAPlaceForEachDiscACellForEachResidualAndAllDirections) {
  CalibrationDrawing drawing{640, 480, {{{10, 10}, {20, 20}}, {{300, 200}}}, {{{100, 100}, 0.02}, {{600, 400}, 0.01}},
                             4,   3,   std::vector<double>(12, 0.03),        "a title"};
  drawing.direction_sigma_px[5] = std::numeric_limits<double>::infinity();
  const std::string svg = draw_calibration(drawing);
  EXPECT_EQ(count(svg, "<circle"), 3U);
  EXPECT_EQ(count(svg, "<rect"), 2U + 3U + 2U + 12U);  // two grounds, frames, cells with residuals, directions
  EXPECT_NE(svg.find("a title"), std::string::npos);
  EXPECT_NE(svg.find("white 0 to black 0.05 px"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
}

TEST(CalibrationPicture, WritesTheNumbersOfDirectionsAboveAllCells) {
  const CalibrationDrawing drawing{640, 480, {}, {}, 8, 8, std::vector<double>(64, 0.012), "a title"};
  const std::string svg = draw_calibration(drawing);
  const std::size_t first = svg.find(">0.012</text>");
  ASSERT_NE(first, std::string::npos);
  EXPECT_EQ(count(svg.substr(first), "<rect"), 1U) << "the frame alone";
}

}  // namespace
}  // namespace ninedot
