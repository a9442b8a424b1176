#pragma once
/// Options that name a file or a folder.
#include <CLI/CLI.hpp>
#include <string>

namespace ninedot {

/// For CLI::Option::check: an empty name, as of a script whose variable is empty, is refused as wrong usage. Without it
/// it would count as an option that was left out.
inline CLI::Validator is_named() {
  return CLI::Validator(
      [](const std::string& name) {
        return name.empty() ? std::string("names nothing: give it a name, or leave it out") : std::string();
      },
      "");
}

}  // namespace ninedot
