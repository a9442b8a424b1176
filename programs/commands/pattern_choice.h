#pragma once
/// Which landmarks `ninedot pattern` prints.
#include <string>
#include <vector>

#include "config/config.h"
#include "drawing/pattern.h"
#include "drawing/pattern_contents.h"

namespace ninedot {

/// Landmarks of the dictionary, with the lengths and the paper of `lengths`.
/// \param words  of --id: each a number, or two with a hyphen between them, the first and the last of a row
/// Throws StartupError(kWrongUsage): a word that is neither, a number without a code, one that is named twice.
std::vector<PatternOptions> known_landmarks(const std::vector<std::string>& words, const PatternOptions& lengths);

/// The landmark with this code. Throws nothing: make_pattern_page looks at the code.
PatternOptions landmark_of_code(const std::string& code, const PatternOptions& lengths);

/// What a configuration's map holds, by rising id; its own black-and-white landmark where it has none.
std::vector<ListedLandmark> landmarks_of_map(const Config& config);

/// For each of a list the sheet to print.
std::vector<PatternOptions> listed_landmarks(const std::vector<ListedLandmark>& list, const PatternOptions& lengths);

}  // namespace ninedot
