// A table of six columns of numbers and the code, 120 mm wide: it fits the narrowest paper between the margins.
#include "drawing/pattern_contents.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "drawing/paper.h"
#include "world/landmark_codes.h"

namespace ninedot {
namespace {

constexpr double kTableWidth_mm = kNarrowestPaper_mm - 2 * kPrinterMargin_mm;
constexpr double kTitleLine_mm = 15, kLengthsLine_mm = 22, kHeadLine_mm = 36, kFirstLine_mm = 43;  // from the top
constexpr double kLineStep_mm = 5, kTextSize_mm = 3.2, kTitleSize_mm = 5;
constexpr double kBottom_mm = 10;  // left free

// Numbers end at these, so that digits stand below each other; from the table's left end. Wide enough for the largest
// that the configuration takes: 10 km with a tenth of a millimetre, 17.6 mm of Helvetica.
constexpr double kPageEnds_mm = 10, kIdEnds_mm = 22, kCodeStarts_mm = 26, kHeadingEnds_mm = kTableWidth_mm;
constexpr std::array<double, 3> kPositionEnds_mm{67, 86, 105};

class Table {
 public:
  Table(PatternPage& page) : page_(page), left_mm_((page.width_mm - kTableWidth_mm) / 2) {}

  void put(double start_mm, double y_mm, const std::string& words, double size_mm = kTextSize_mm) {
    page_.items.emplace_back(PageText{{left_mm_ + start_mm, y_mm}, size_mm, words});
  }
  void put_ending(double end_mm, double y_mm, const std::string& words) {
    put(end_mm - text_width_mm(words, kTextSize_mm), y_mm, words);
  }
  void put_head() {
    put_ending(kPageEnds_mm, kHeadLine_mm, "page");
    put_ending(kIdEnds_mm, kHeadLine_mm, "id");
    put(kCodeStarts_mm, kHeadLine_mm, "code");
    const std::array<const char*, 3> axes{"x mm", "y mm", "z mm"};
    for (std::size_t axis = 0; axis < 3; ++axis) put_ending(kPositionEnds_mm[axis], kHeadLine_mm, axes[axis]);
    put_ending(kHeadingEnds_mm, kHeadLine_mm, "heading");
    const double y_mm = kHeadLine_mm + 2;
    page_.items.emplace_back(PageLine{{left_mm_, y_mm}, {left_mm_ + kTableWidth_mm, y_mm}, 0.25, {}});
  }
  void put_landmark(double y_mm, std::size_t page_number, const ListedLandmark& landmark) {
    put_ending(kPageEnds_mm, y_mm, fmt::format("{}", page_number));
    put_ending(kIdEnds_mm, y_mm, fmt::format("{}", landmark.landmark_id));
    put(kCodeStarts_mm, y_mm, is_black_and_white(landmark.code) ? "black and white" : landmark.code);
    if (!landmark.position_mm) return;
    for (std::size_t axis = 0; axis < 3; ++axis)
      put_ending(kPositionEnds_mm[axis], y_mm, fmt::format("{:.1f}", (*landmark.position_mm)[axis]));
    put_ending(kHeadingEnds_mm, y_mm, landmark.heading_deg ? fmt::format("{:.1f}", *landmark.heading_deg) : "tilted");
  }

 private:
  PatternPage& page_;
  const double left_mm_;
};

}  // namespace

std::vector<PatternPage> make_contents_pages(std::span<const ListedLandmark> landmarks, const PatternOptions& lengths) {
  const Paper paper = parse_sheet(lengths.sheet);
  const auto lines_a_page =
      static_cast<std::size_t>(std::floor((paper.height_mm - kBottom_mm - kFirstLine_mm) / kLineStep_mm)) + 1;
  const std::size_t count = (landmarks.size() + lines_a_page - 1) / lines_a_page;
  std::vector<PatternPage> pages;
  for (std::size_t first = 0; first < landmarks.size(); first += lines_a_page) {
    PatternPage& page = pages.emplace_back();
    page.width_mm = paper.width_mm, page.height_mm = paper.height_mm;
    page.title = fmt::format("ninedot landmarks, contents, {} of {}", pages.size(), count);
    Table table(page);
    table.put(0, kTitleLine_mm, page.title, kTitleSize_mm);
    table.put(0, kLengthsLine_mm,
              fmt::format("{} {}: {}", landmarks.size(), landmarks.size() == 1 ? "sheet" : "sheets",
                          describe_lengths(lengths)));
    table.put(0, kLengthsLine_mm + kLineStep_mm, "x, y and z of P9 in the world, heading in degrees about Z");
    table.put_head();
    const auto lines = landmarks.subspan(first, std::min(lines_a_page, landmarks.size() - first));
    for (std::size_t i = 0; i < lines.size(); ++i)
      table.put_landmark(kFirstLine_mm + static_cast<double>(i) * kLineStep_mm, count + first + i + 1, lines[i]);
  }
  return pages;
}

}  // namespace ninedot
