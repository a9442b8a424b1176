// The layout, from top to bottom: a band with the arrow, the white sheet, a band with the scale bar and the words. The
// bands lie outside of the sheet, so nothing but dots is on it and they can be cut off.
#include "drawing/pattern.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "base/startup_error.h"
#include "drawing/page_parts.h"
#include "drawing/paper.h"
#include "geometry/landmark_faults.h"
#include "world/landmark_codes.h"

namespace ninedot {
namespace {

// Above: the arrow, and 2 to the sheet. Below: 12 to the bar, five lines of 5, and the printer's margin.
constexpr double kTopBand_mm = 18, kBottomBand_mm = 44;
constexpr double kLargestLength_mm = 10000;                     // as [landmark] of the configuration
constexpr PageColour kBlack{0, 0, 0}, kCutGrey{0.6, 0.6, 0.6};  // seen by who cuts, too light for a dot

constexpr double kLeastWhite_radii = 0.9;  // beside the ring dots, in dot radii: what the paper must leave

// Dark enough that each has at most 30 % of the paper's luma (BT.601), so the detector sees a dot, and pure in hue.
constexpr PageColour kRed{0.8, 0, 0}, kGreen{0, 0.5, 0}, kBlue{0, 0, 0.8};

[[noreturn]] void refuse(const std::string& line) { throw StartupError(ExitStatus::kWrongUsage, line); }

PageColour colour_of(char letter) {
  switch (letter) {
    case 'R':
      return kRed;
    case 'G':
      return kGreen;
    case 'B':
      return kBlue;
    default:
      return kBlack;
  }
}

void check_code(const std::string& code) {
  if (code.empty()) return;
  if (!is_landmark_code(code))
    refuse(fmt::format("--code {}: give eight letters of K R G B, for P1 to P8, for example KRGBKKRB", code));
  if (is_black_and_white(code)) return;
  if (const CodeDistance own = own_distance(code); own.places < kLeastCodeDistance)
    refuse(
        fmt::format("--code {}: it looks the same after a turn by {} {}, so nobody can tell which way is up: change a "
                    "letter",
                    code, own.turn, own.turn == 1 ? "dot" : "dots"));
}

void check_lengths(const PatternOptions& o) {
  const auto check = [](const char* option, double length_mm) {
    if (!(length_mm > 0 && length_mm <= kLargestLength_mm))
      refuse(fmt::format("{} {}: give a length above 0 and up to {} mm", option, length_mm, kLargestLength_mm));
  };
  check("--ring-radius-mm", o.ring_radius_mm);
  check("--dot-diameter-mm", o.dot_diameter_mm);
  check("--centre-diameter-mm", o.centre_diameter_mm);
  const LandmarkFaults faults =
      find_landmark_faults({o.ring_radius_mm, o.dot_diameter_mm / 2, o.centre_diameter_mm / 2});  // in mm here
  if (faults.centre_not_largest)
    refuse(fmt::format(
        "--centre-diameter-mm {}: it must be larger than --dot-diameter-mm {}: that is how it is recognised",
        o.centre_diameter_mm, o.dot_diameter_mm));
  if (faults.ring_dots_touch || faults.centre_touches_ring)
    refuse(
        fmt::format("dots touch: with --ring-radius-mm {0:g} use for example --dot-diameter-mm {1:.1f} "
                    "--centre-diameter-mm {2:.1f}",
                    o.ring_radius_mm, o.ring_radius_mm * 25.4 / 80, o.ring_radius_mm * 50.8 / 80));
}

double sheet_side_mm(const PatternOptions& o) {
  return 2 * o.ring_radius_mm + o.dot_diameter_mm * (1 + LandmarkGeometry::kWhite_radii);
}

/// The factor by which the landmark may grow (below 1: must shrink) to just fit: dots within the printer's reach,
/// enough white at the paper's edge, and the bands above and below the sheet.
double largest_factor(const PatternOptions& o, const Paper& paper) {
  const double half_mm = paper.width_mm / 2, dot_radius_mm = o.dot_diameter_mm / 2;
  return std::min({(half_mm - kPrinterMargin_mm) / (o.ring_radius_mm + dot_radius_mm),
                   half_mm / (o.ring_radius_mm + dot_radius_mm * (1 + kLeastWhite_radii)),
                   (paper.height_mm - kTopBand_mm - kBottomBand_mm) / sheet_side_mm(o)});
}

void check_fit(const PatternOptions& o, const Paper& paper) {
  const double factor = largest_factor(o, paper);
  if (factor >= 1) return;
  const auto shrunk = [&](double length_mm) { return std::floor(length_mm * factor * 10) / 10; };
  refuse(fmt::format(
      "the landmark does not fit on {0} ({1:g} x {2:g} mm): use a larger --sheet, or at most --ring-radius-mm {3:.1f} "
      "--dot-diameter-mm {4:.1f} --centre-diameter-mm {5:.1f}",
      o.sheet, paper.width_mm, paper.height_mm, shrunk(o.ring_radius_mm), shrunk(o.dot_diameter_mm),
      shrunk(o.centre_diameter_mm)));
}

void add_dots(PatternPage& page, const PatternOptions& o, const PagePoint& middle) {
  const LandmarkGeometry geometry{o.ring_radius_mm, o.dot_diameter_mm / 2, o.centre_diameter_mm / 2};  // in mm here
  for (std::size_t dot = 0; dot < kDotCount; ++dot) {
    const Eigen::Vector2d centre_mm = geometry.centre_m(dot);
    const PageColour colour = dot == kCentreDot || o.code.empty() ? kBlack : colour_of(o.code[dot]);
    // X0 points to the viewer's left, Z0 up; the page's x to the right, y down.
    page.items.emplace_back(
        PageDisc{{middle.x_mm - centre_mm.x(), middle.y_mm - centre_mm.y()}, 2 * geometry.radius_m(dot), colour});
  }
}

/// Sides that fall on the edge of the paper or where no printer reaches are left out: there the paper's edge is the
/// cut.
void add_cut_lines(PatternPage& page, const PagePoint& middle, double side_mm) {
  const double right_end_mm = page.width_mm - kPrinterMargin_mm;
  const double left = middle.x_mm - side_mm / 2, right = middle.x_mm + side_mm / 2;
  const double top = middle.y_mm - side_mm / 2, bottom = middle.y_mm + side_mm / 2;
  const double from = std::max(left, kPrinterMargin_mm), to = std::min(right, right_end_mm);
  constexpr double kWidth_mm = 0.15;  // two dots of a 300 dpi printer
  for (const double y : {top, bottom}) page.items.emplace_back(PageLine{{from, y}, {to, y}, kWidth_mm, kCutGrey});
  if (left < kPrinterMargin_mm) return;
  for (const double x : {left, right}) page.items.emplace_back(PageLine{{x, top}, {x, bottom}, kWidth_mm, kCutGrey});
}

void add_up_arrow(PatternPage& page) {
  const double x = page.width_mm / 2, top = 6;
  page.items.emplace_back(PageTriangle{{{x, top}, {x - 2.5, top + 5}, {x + 2.5, top + 5}}});
  page.items.emplace_back(PageLine{{x, top + 5}, {x, top + 10}, 1.2, kBlack});
  page.items.emplace_back(PageText{{x + 5, top + 7}, 5, "UP"});
}

}  // namespace

std::string describe_lengths(const PatternOptions& options) {
  return fmt::format("ring radius {:g} mm, dots {:g} mm, centre dot {:g} mm in diameter", options.ring_radius_mm,
                     options.dot_diameter_mm, options.centre_diameter_mm);
}

PatternPage make_pattern_page(const PatternOptions& options) {
  check_code(options.code);
  check_lengths(options);
  const Paper paper = parse_sheet(options.sheet);
  check_fit(options, paper);

  PatternPage page;
  page.width_mm = paper.width_mm, page.height_mm = paper.height_mm;
  const std::string kind = is_black_and_white(options.code) ? "black and white" : "code " + options.code;
  page.title = options.landmark_id ? fmt::format("ninedot landmark {}, {}", *options.landmark_id, kind)
                                   : "ninedot landmark, " + kind;
  const double side_mm = sheet_side_mm(options);
  const PagePoint middle{paper.width_mm / 2, kTopBand_mm + side_mm / 2};
  add_cut_lines(page, middle, side_mm);
  add_dots(page, options, middle);
  add_up_arrow(page);

  const PagePoint bar{paper.width_mm / 2 - kScaleBar_mm / 2, kTopBand_mm + side_mm + 12};
  add_scale_bar(page, bar);
  const std::vector<std::string> lines{"check: this bar is 100 mm long", page.title, describe_lengths(options),
                                       "print at 100 % - actual size, not fitted to the page - on matt paper",
                                       "cut along the grey lines; mount flat, arrow up: P1 is the lowest dot"};
  add_lines(page, {bar.x_mm, bar.y_mm + 5}, lines);
  return page;
}

}  // namespace ninedot
