#pragma once
/// The printed landmark: a page laid out in millimetres, and its exact form as SVG and PDF.
#include <optional>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace ninedot {

/// What to print. Lengths in mm, as the configuration's [landmark] names them.
struct PatternOptions {
  std::optional<int> landmark_id = 0;  ///< nothing: the code has no number
  std::string code;                    ///< P1..P8, eight of K R G B; empty = all black
  double ring_radius_mm = 80.0;
  double dot_diameter_mm = 25.4;
  double centre_diameter_mm = 50.8;
  std::string sheet = "a4";  ///< as parse_sheet of drawing/paper.h takes it
};

/// Page coordinates: mm from the upper left corner of the paper, x right, y down.
struct PagePoint {
  double x_mm = 0, y_mm = 0;
};

/// Each a part of the brightest [1], 0..1.
struct PageColour {
  double red = 0, green = 0, blue = 0;
};

struct PageDisc {
  PagePoint centre;
  double diameter_mm = 0;
  PageColour colour;
};
struct PageLine {
  PagePoint from, to;
  double width_mm = 0;
  PageColour colour;
};
struct PageTriangle {
  PagePoint corners[3];
};
struct PageText {
  PagePoint base_line_start;
  double size_mm = 0;  ///< the font's, so capitals are about 0.72 of it
  std::string words;   ///< letters, digits and . , : ; % - only, which neither format has to escape
};
using PageItem = std::variant<PageDisc, PageLine, PageTriangle, PageText>;

struct PatternPage {
  double width_mm = 0, height_mm = 0;
  std::string title;
  std::vector<PageItem> items;  ///< drawn in this order
};

/// Lays the landmark out: nine dots, cut lines around the white sheet, and outside of it an arrow up, a scale bar of
/// 100 mm and what the landmark is. Throws StartupError(kWrongUsage): a wrong letter, length or sheet; dots that touch;
/// a code that equals one of its own rotations; a landmark too large for the paper (the line names the largest that
/// fits).
PatternPage make_pattern_page(const PatternOptions& options);

/// "ring radius 80 mm, dots 25.4 mm, ..."
std::string describe_lengths(const PatternOptions& options);

/// A whole file each. Lengths are exact to 1e-6 mm; the PDF's discs are made of eight Bezier arcs, radius true to 5e-6
/// of it.
std::string encode_svg(const PatternPage& page);
/// \param pages  in this order; the file has the title of the first one; at least one (contract)
std::string encode_pdf(std::span<const PatternPage> pages);

}  // namespace ninedot
