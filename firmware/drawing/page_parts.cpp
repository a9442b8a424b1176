#include "drawing/page_parts.h"

namespace ninedot {
namespace {

constexpr PageColour kBlack{0, 0, 0};
constexpr double kLineHeight_mm = 5, kLetters_mm = 3.2;

}  // namespace

void add_scale_bar(PatternPage& page, const PagePoint& left) {
  constexpr double kWidth_mm = 0.25;  // one of the line widths of ISO 128
  page.items.emplace_back(PageLine{left, {left.x_mm + kScaleBar_mm, left.y_mm}, kWidth_mm, kBlack});
  for (int i = 0; i <= 10; ++i) {
    const double x = left.x_mm + kScaleBar_mm * i / 10;
    const double length_mm = i == 0 || i == 10 ? 6 : i == 5 ? 4 : 2.5;
    page.items.emplace_back(PageLine{{x, left.y_mm}, {x, left.y_mm - length_mm}, kWidth_mm, kBlack});
  }
}

void add_lines(PatternPage& page, PagePoint first, const std::vector<std::string>& lines) {
  for (const std::string& line : lines) {
    page.items.emplace_back(PageText{first, kLetters_mm, line});
    first.y_mm += kLineHeight_mm;
  }
}

}  // namespace ninedot
