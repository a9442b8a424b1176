#pragma once
/// Many mistakes at once, as a look at a whole configuration finds them.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>
#include <vector>

#include "base/startup_error.h"

namespace ninedot {

/// A StartupError(kWrongUsage) of several lines, each of which says what to do. Of any other the program prints one
/// line, whatever line breaks stand in a path that it quotes.
class StartupErrors : public StartupError {
 public:
  /// \param lines  without line breaks; `what()` has one between two of them
  explicit StartupErrors(const std::vector<std::string>& lines)
      : StartupError(ExitStatus::kWrongUsage, fmt::format("{}", fmt::join(lines, "\n"))) {}
};

}  // namespace ninedot
