#pragma once
/// A printed landmark as a file.
#include <string>

#include "drawing/pattern.h"

namespace ninedot {

/// Writes FILE.svg or FILE.pdf under a temporary name and renames it: never half a file.
/// Throws StartupError: kWrongUsage for another ending, kWorkFailed when the file cannot be written.
void write_pattern(const PatternPage& page, const std::string& path);

}  // namespace ninedot
