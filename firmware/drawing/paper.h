#pragma once
/// Paper to print landmarks on, and how wide words are there.
#include <string>
#include <string_view>

namespace ninedot {

/// Upright: not wider than high.
struct Paper {
  double width_mm = 0, height_mm = 0;
};

inline constexpr double kPrinterMargin_mm = 5;     ///< few office printers reach closer to the edge
inline constexpr double kNarrowestPaper_mm = 130;  ///< the scale bar of 100 mm, and 15 on both sides

/// The paper of --sheet: a0 to a5, letter, or WIDTHxHEIGHT in mm, whichever way round. Throws
/// StartupError(kWrongUsage): no such paper, narrower than kNarrowestPaper_mm, or larger than a PDF page.
Paper parse_sheet(const std::string& sheet);

/// Width in Helvetica, whose metrics Arial shares. \param words  printable ASCII (contract) \param size_mm  of the font
/// Memory: none. Threads: pure. Source: Adobe Core 14 font metrics, Helvetica.afm.
double text_width_mm(std::string_view words, double size_mm) noexcept;

}  // namespace ninedot
