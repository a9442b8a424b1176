#include "drawing/paper.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cstdint>

#include "base/contract.h"
#include "base/startup_error.h"

namespace ninedot {
namespace {

constexpr double kLargestPaper_mm = 5000;  // a PDF page ends at 14400 points = 5080 mm
constexpr Paper kLetter{215.9, 279.4};     // ANSI/ASME Y14.1
constexpr std::array<Paper, 6> kIso216{{{841, 1189}, {594, 841}, {420, 594}, {297, 420}, {210, 297}, {148, 210}}};

/// Of ' ' to '~', in thousandths of the font's size.
constexpr std::array<std::uint16_t, 95> kHelvetica{
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333,  278, 278, 556, 556, 556,
    556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556, 1015, 667, 667, 722, 722, 667,
    611, 778, 722, 278, 500, 667, 556, 833, 722, 778, 667, 778, 722, 667,  611, 722, 667, 944, 667,
    667, 611, 278, 278, 278, 469, 556, 333, 556, 556, 500, 556, 556, 278,  556, 556, 222, 222, 500,
    222, 833, 556, 556, 556, 556, 333, 500, 278, 556, 500, 722, 500, 500,  500, 334, 260, 334, 584};

[[noreturn]] void refuse(const std::string& line) { throw StartupError(ExitStatus::kWrongUsage, line); }

}  // namespace

Paper parse_sheet(const std::string& sheet) {
  std::string name = sheet;
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (name == "letter") return kLetter;
  if (name.size() == 2 && name[0] == 'a' && name[1] >= '0' && name[1] <= '5')
    return kIso216[static_cast<std::size_t>(name[1] - '0')];
  double first_mm = 0, second_mm = 0;
  const char* const end = name.data() + name.size();
  const auto first = std::from_chars(name.data(), end, first_mm);
  const bool has_cross = first.ec == std::errc{} && first.ptr != end && *first.ptr == 'x';
  const auto second = has_cross ? std::from_chars(first.ptr + 1, end, second_mm) : first;
  if (!has_cross || second.ec != std::errc{} || second.ptr != end)
    refuse(fmt::format("--sheet {}: give a0 to a5, letter, or WIDTHxHEIGHT in mm, for example 210x297", sheet));
  const Paper paper{std::min(first_mm, second_mm), std::max(first_mm, second_mm)};
  if (!(paper.width_mm >= kNarrowestPaper_mm && paper.height_mm <= kLargestPaper_mm))
    refuse(fmt::format("--sheet {}: give sides of at least {} mm, for the scale bar, and at most {} mm", sheet,
                       kNarrowestPaper_mm, kLargestPaper_mm));
  return paper;
}

double text_width_mm(std::string_view words, double size_mm) noexcept {
  double thousandths = 0;
  for (const char c : words) {
    EXPECTS(c >= ' ' && c <= '~');
    thousandths += kHelvetica[static_cast<std::size_t>(c - ' ')];
  }
  return size_mm * thousandths / 1000;
}

}  // namespace ninedot
