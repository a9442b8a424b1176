#pragma once
/// The list of the landmarks at the front of a file with many of them: which page is to hang where.
#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "drawing/pattern.h"

namespace ninedot {

struct ListedLandmark {
  int landmark_id = 0;
  std::string code;                                  ///< P1..P8, eight of K R G B; empty = black and white
  std::optional<std::array<double, 3>> position_mm;  ///< of P9 in the world; nothing: unknown
  std::optional<double> heading_deg;  ///< about the world's Z; nothing: the place is unknown, or it leans or is rolled
};

/// As many pages as the list needs. The landmarks' own pages follow it in the order of the list, and the list counts
/// from the first page of the contents. \param lengths  what all of them share, and the paper
/// Throws StartupError(kWrongUsage): no such paper.
std::vector<PatternPage> make_contents_pages(std::span<const ListedLandmark> landmarks, const PatternOptions& lengths);

}  // namespace ninedot
