// Reads the file against the table in config_reference.cpp. All mistakes are collected; who reports a
// single one takes that nearest to the top of the file, because that is where the user starts to read.
#include "config/config.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>

#include "base/one_line.h"
#include "base/startup_error.h"
#include "base/suggestion.h"
#include "base/units.h"
#include "config/config_checks.h"
#include "config/config_reference.h"
#include "config/landmark_checks.h"
#include "config/toml_text.h"

namespace ninedot {
namespace {

std::string_view next_choice(std::string_view& choices) {
  const std::string_view choice = choices.substr(0, choices.find('|'));
  choices.remove_prefix(std::min(choices.size(), choice.size() + 1));
  return choice;
}

/// A list of tables, [[...]].
struct ListOfTables {
  std::string_view table;
  /// Adds an entry. \return  its index
  std::size_t (*add)(Config& config);
  std::string_view entry;                  ///< in words
  std::array<std::string_view, 2> needed;  ///< keys that each entry must have; empty: none
};

template <typename Entries>
std::size_t add_to(Entries& entries) {
  entries.emplace_back();
  return entries.size() - 1;
}

constexpr std::array kLists{
    ListOfTables{"landmarks", [](Config& config) { return add_to(config.landmarks); }, "a landmark", {"id", ""}},
    ListOfTables{
        "simulation.robot", [](Config& config) { return add_to(config.simulation.robot); }, "a way-point", {"t_s", ""}},
    ListOfTables{"simulation.hidden",
                 [](Config& config) { return add_to(config.simulation.hidden); },
                 "a hidden interval",
                 {"from_s", "to_s"}},
};

const ListOfTables* list_of(std::string_view table) {
  const auto* const found = std::ranges::find(kLists, table, &ListOfTables::table);
  return found == kLists.end() ? nullptr : found;
}

class ConfigReader {
 public:
  ConfigReader(const toml::table& root, ConfigProblems& problems) : root_(root), problems_(problems) {}

  Config read() {
    read_table(root_, "", "");
    return std::move(config_);
  }

  /// Of a map: its landmarks alone.
  std::vector<MapLandmarkConfig> read_map() {
    for (const auto& [key, node] : root_) {
      const int line = static_cast<int>(key.source().begin.line);
      if (key.str() == "landmarks")
        read_list(node, kLists.front(), line);
      else
        problems_.add(line, fmt::format("'{}' does not belong here: a map holds [[landmarks]] only", key.str()));
    }
    return std::move(config_.landmarks);
  }

 private:
  static std::string join(std::string_view path, std::string_view key) {
    return path.empty() ? std::string(key) : fmt::format("{}.{}", path, key);
  }

  /// \param place  the path, with the index of an entry: "landmarks.0"
  void read_table(const toml::table& table, std::string_view path, std::string_view place) {
    for (const auto& [key, node] : table) {
      const std::string full = join(path, key.str());
      const int line = static_cast<int>(key.source().begin.line);
      problems_.lines.try_emplace(join(place, key.str()), line);
      if (const ListOfTables* list = list_of(full))
        read_list(node, *list, line);
      else if (!full.empty() && !config_table_meaning(full).empty())
        read_sub_table(node, full, line);
      else
        read_key(node, path, key.str(), line);
    }
  }

  void read_sub_table(const toml::node& node, const std::string& path, int line) {
    if (path == "modbus.tcp") config_.modbus_tcp.enabled = true;
    if (path == "modbus.rtu") config_.modbus_rtu.enabled = true;
    if (const toml::table* table = node.as_table())
      read_table(*table, path, path);
    else
      problems_.add(line, fmt::format("'{0}' is a table; write [{0}]", path));
  }

  void read_list(const toml::node& node, const ListOfTables& list, int line) {
    const toml::array* array = node.as_array();
    if (array == nullptr || !std::ranges::all_of(*array, [](const toml::node& item) { return item.is_table(); })) {
      problems_.add(line, fmt::format("'{0}' is a list of tables; write [[{0}]]", list.table));
      return;
    }
    for (const toml::node& item : *array) {
      const std::string place = fmt::format("{}.{}", list.table, list.add(config_));
      const int entry_line = static_cast<int>(item.source().begin.line);
      problems_.lines.emplace(place, entry_line);
      read_table(*item.as_table(), list.table, place);
      for (const std::string_view key : list.needed)
        if (!key.empty() && !item.as_table()->contains(key))
          problems_.add(entry_line, fmt::format("{} needs {} '{}'", list.entry, key == "id" ? "an" : "a", key));
    }
  }

  void read_key(const toml::node& node, std::string_view path, std::string_view name, int line) {
    for (const ConfigKey& key : config_keys())
      if (key.table == path && key.name == name) {
        std::visit([&](auto slot) { assign(key, node, slot, line); }, key.slot(config_));
        return;
      }
    refuse_unknown(node, path, name, line);
  }

  void refuse_unknown(const toml::node& node, std::string_view path, std::string_view name, int line) {
    Suggestion suggestion(name);
    for (const ConfigKey& key : config_keys()) {
      if (key.table == path) suggestion.consider(key.name);
      if (path.empty() && node.is_table()) suggestion.consider(key.table);
    }
    std::string hint = suggestion.text();
    for (const ConfigKey& key : config_keys())
      if (hint.empty() && key.name == name)
        hint = key.table.empty() ? "; it belongs above all tables" : fmt::format("; it belongs to [{}]", key.table);
    if (node.is_table() || node.is_array_of_tables())
      problems_.add(line, fmt::format("unknown table '{}'{}", join(path, name), hint));
    else
      problems_.add(line,
                    fmt::format("unknown key '{}'{}{}", name, path.empty() ? "" : fmt::format(" in [{}]", path), hint));
  }

  void refuse_type(const ConfigKey& key, int line, std::string_view expected) {
    problems_.add(line, fmt::format("'{}' must be {}", key.name, expected));
  }

  void assign(const ConfigKey& key, const toml::node& node, bool* slot, int line) {
    if (const auto* value = node.as_boolean())
      *slot = value->get();
    else
      refuse_type(key, line, "true or false");
  }

  void assign(const ConfigKey& key, const toml::node& node, double* slot, int line) {
    std::optional<double> number;
    if (const auto* value = node.as_floating_point()) number = value->get();
    if (const auto* value = node.as_integer()) number = static_cast<double>(value->get());
    if (!number || !std::isfinite(*number)) return refuse_type(key, line, "a finite number");
    if (*number < key.min || *number > key.max) return refuse_range(key, fmt::format("{}", *number), line);
    *slot = *number;
  }

  void assign(const ConfigKey& key, const toml::node& node, std::optional<double>* slot, int line) {
    double number = 0;
    const std::size_t problems_before = problems_.list.size();
    assign(key, node, &number, line);
    if (problems_.list.size() == problems_before) *slot = number;
  }

  template <typename Integer>
  void assign_integer(const ConfigKey& key, const toml::node& node, Integer* slot, int line) {
    const auto* value = node.as_integer();
    if (value == nullptr) return refuse_type(key, line, "a whole number");
    const std::int64_t number = value->get();
    if (static_cast<double>(number) < key.min || static_cast<double>(number) > key.max)
      return refuse_range(key, fmt::format("{}", number), line);
    *slot = static_cast<Integer>(number);
  }
  void assign(const ConfigKey& key, const toml::node& node, int* slot, int line) {
    assign_integer(key, node, slot, line);
  }
  void assign(const ConfigKey& key, const toml::node& node, std::uint16_t* slot, int line) {
    assign_integer(key, node, slot, line);
  }
  void assign(const ConfigKey& key, const toml::node& node, std::uint32_t* slot, int line) {
    assign_integer(key, node, slot, line);
  }

  void refuse_range(const ConfigKey& key, const std::string& number, int line) {
    problems_.add(line, fmt::format("'{}' is {}; write {} to {}{}{}", key.name, number, key.min, key.max,
                                    key.unit.empty() ? "" : " ", key.unit));
  }

  void assign(const ConfigKey& key, const toml::node& node, std::string* slot, int line) {
    const auto* value = node.as_string();
    if (value == nullptr) return refuse_type(key, line, "a text in quotes");
    if (value->get().find('\0') != std::string::npos) return refuse_type(key, line, "a text without zero bytes");
    if (!key.choices.empty() && !check_choice(key, value->get(), line)) return;
    *slot = value->get();
  }

  bool check_choice(const ConfigKey& key, const std::string& word, int line) {
    Suggestion suggestion(word);
    for (std::string_view choices = key.choices; !choices.empty();) {
      const std::string_view choice = next_choice(choices);
      if (choice == word) return true;
      suggestion.consider(choice);
    }
    std::string all(key.choices);
    for (std::size_t at = 0; (at = all.find('|', at)) != std::string::npos; at += 2) all.replace(at, 1, ", ");
    problems_.add(line, fmt::format("'{}' is '{}'; write one of {}{}", key.name, word, all, suggestion.text()));
    return false;
  }

  void assign(const ConfigKey& key, const toml::node& node, char* slot, int line) {
    std::string word;
    assign(key, node, &word, line);
    if (word.size() == 1) *slot = word[0];
  }

  void assign(const ConfigKey& key, const toml::node& node, std::vector<std::string>* slot, int line) {
    const toml::array* array = node.as_array();
    if (array == nullptr || !std::ranges::all_of(*array, [](const toml::node& item) { return item.is_string(); }))
      return refuse_type(key, line, "a list of texts, [\"...\", \"...\"]");
    for (const toml::node& item : *array) slot->push_back(item.as_string()->get());
  }

  void assign(const ConfigKey& key, const toml::node& node, std::array<double, 3>* slot, int line) {
    assign_numbers(key, node, *slot, "three numbers, [x, y, z]", line);
  }
  void assign(const ConfigKey& key, const toml::node& node, std::optional<std::array<double, 3>>* slot, int line) {
    assign_numbers(key, node, slot->emplace(), "three numbers, [x, y, z]", line);
  }
  void assign(const ConfigKey& key, const toml::node& node, std::optional<std::array<double, 4>>* slot, int line) {
    assign_numbers(key, node, slot->emplace(std::array<double, 4>{1}), "four numbers, [w, x, y, z]", line);
  }
  void assign_numbers(const ConfigKey& key, const toml::node& node, std::span<double> slots, std::string_view expected,
                      int line) {
    const toml::array* array = node.as_array();
    if (array == nullptr || array->size() != slots.size()) return refuse_type(key, line, expected);
    for (std::size_t i = 0; i < slots.size(); ++i) assign(key, (*array)[i], &slots[i], line);
  }

  void assign(const ConfigKey& key, const toml::node& node, std::vector<AxisPoint>* slot, int line) {
    const toml::array* array = node.as_array();
    if (array == nullptr) return refuse_type(key, line, "a list of pairs, [[-45, 1000], [45, 2000]]");
    for (const toml::node& item : *array) {
      const toml::array* pair = item.as_array();
      if (pair == nullptr || pair->size() != 2)
        return refuse_type(key, line, "a list of pairs, [[-45, 1000], [45, 2000]]");
      AxisPoint& point = slot->emplace_back();
      assign(key, (*pair)[0], &point.angle_rad, line);
      point.angle_rad *= kRadPerDeg;
      assign(key, (*pair)[1], &point.output, line);
    }
  }

  const toml::table& root_;
  ConfigProblems& problems_;
  Config config_;
};

}  // namespace

Config read_config_text(std::string_view text, const std::string& name, ConfigProblems& problems) {
  const std::optional<toml::table> root = parse_toml(text, name, problems);
  if (!root) return {};
  Config config = ConfigReader(*root, problems).read();
  if (!config.map.empty() && !config.landmarks.empty())
    problems.add(problems.line_of("landmarks"), "[[landmarks]] and 'map' say the same: keep one of them");
  check_config(config, problems);
  std::ranges::stable_sort(problems.list, {}, &ConfigProblem::place);
  return config;
}

void read_map_text(std::string_view text, const std::string& name, Config& config, ConfigProblems& problems) {
  ConfigProblems own;
  if (const std::optional<toml::table> root = parse_toml(text, name, own)) {
    config.landmarks = ConfigReader(*root, own).read_map();
    if (config.landmarks.empty() && own.list.empty()) own.add(1, "a map needs [[landmarks]]");
    check_landmarks(config, own);
    if (own.list.empty()) check_outputs(config, problems);
  }
  std::ranges::stable_sort(own.list, {}, &ConfigProblem::place);
  for (ConfigProblem& problem : own.list) {
    problem.file = name;
    problems.list.push_back(std::move(problem));
  }
  problems.lines.try_emplace("landmarks", problems.line_of("map"));
}

std::string problem_text(const std::string& name, const ConfigProblem& problem) {
  return one_line(fmt::format("{}:{}: {}", problem.file.empty() ? name : problem.file, problem.line, problem.what));
}

Config parse_config(std::string_view text, const std::string& name, ConfigProblems& problems) {
  Config config = read_config_text(text, name, problems);
  if (!problems.list.empty()) throw StartupError(ExitStatus::kWrongUsage, problem_text(name, problems.list.front()));
  return config;
}

}  // namespace ninedot
