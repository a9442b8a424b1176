#pragma once
/// Keys of a configuration's text, set where they stand. Nothing else of it is touched: its comments, its order and its
/// blanks are somebody's.
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace ninedot {

struct KeyText {
  std::string table;  ///< "pan_tilt.pan"
  std::string key;
  std::string value;  ///< as TOML writes it; may have comments in it where it has several lines
};

/// The keys of a text's tables, in its order; no lists of tables, and none without a table.
/// Throws StartupError(kWrongUsage) with "NAME:LINE: what": it is no TOML.
std::vector<KeyText> keys_of(std::string_view text, const std::string& name);

/// Each key takes the place of the one that has its name, else it is the first of its table; a table that is not there
/// is the last. \param name  of the text's file, for errors
/// Throws StartupError(kWrongUsage) with one line: it is no TOML, or has a table in another form than under its own
/// [head]. Memory: allocates. Threads: pure.
std::string with_keys(std::string text, std::span<const KeyText> keys, const std::string& name);

/// With the key `map` at the top, and without the [[landmarks]], whose place it takes.
/// \param map  as TOML writes it \param name  of the text's file, for errors
/// Throws StartupError(kWrongUsage) with one line: it is no TOML, or has its landmarks in another form than each under
/// a [[landmarks]] of its own. Memory: allocates. Threads: pure.
std::string with_map_named(std::string text, const std::string& map, const std::string& name);

}  // namespace ninedot
