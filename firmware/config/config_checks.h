#pragma once
/// What a configuration's keys must fulfil together, beyond each one's own range.
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "config/config.h"

namespace ninedot {

struct ConfigProblem {
  int line = 0;  ///< from 1
  std::string what;
  std::string file;  ///< the map's, as it is called; empty: the configuration itself

  /// For sorting: the configuration's own before the map's, each by rising line.
  std::pair<std::string_view, int> place() const { return {file, line}; }
};

/// An address of this machine's own, which no other one can reach.
bool is_loopback(const std::string& address);

/// What is wrong with a configuration file, and where its keys stand.
struct ConfigProblems {
  std::vector<ConfigProblem> list;
  bool can_be_read = true;  ///< false: it is no TOML, and nothing is known of any key
  /// Line of "camera.rate_hz", "landmarks.0.code", "modbus.tcp", ...; only of what the file itself holds.
  std::map<std::string, int, std::less<>> lines;

  void add(int line, std::string what) { list.push_back({line, std::move(what), {}}); }
  /// Line of a key; else of the table it belongs to; else 1.
  int line_of(std::string_view key) const;
  /// Whether one of them lies in a table: "camera", "modbus" (and its own tables). The map's lie in "landmarks".
  bool is_in(std::string_view table) const;
};

/// Touching dots, repeated identities, codes that can't be told apart, addresses that are none, rates that don't exist,
/// heads that can't be, devices that are missing or named twice.
void check_config(const Config& config, ConfigProblems& problems);

/// Reads and checks the text of a configuration file. All that is wrong is in `problems.list` afterwards, by rising
/// line; what was wrong has its default in the result. \param name  how errors call the file \param problems  empty
Config read_config_text(std::string_view text, const std::string& name, ConfigProblems& problems);

/// Reads and checks the file that the key `map` names, into config.landmarks. What is wrong is added to `problems`,
/// with the file. \param name  how errors call the map \param problems  of the configuration, which says `map`
void read_map_text(std::string_view text, const std::string& name, Config& config, ConfigProblems& problems);

/// "NAME:LINE: what is wrong and what to write instead", in one line whatever the file holds; NAME is the problem's own
/// file where it has one.
std::string problem_text(const std::string& name, const ConfigProblem& problem);

/// The same, for those who can go on without a mistake only: throws StartupError(kWrongUsage) with the first one.
Config parse_config(std::string_view text, const std::string& name, ConfigProblems& problems);

}  // namespace ninedot
