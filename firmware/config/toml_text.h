#pragma once
/// TOML of whoever wrote it.
#include <toml++/toml.h>
#include <optional>
#include <string>
#include <string_view>

#include "config/config_checks.h"

namespace ninedot {

/// \param name  of the text's file \return  nothing: it is no TOML, or made to exhaust its reader, and `problems` says
/// where. Memory: allocates; of the stack half of a thread's at most. Threads: pure.
std::optional<toml::table> parse_toml(std::string_view text, const std::string& name, ConfigProblems& problems);

}  // namespace ninedot
