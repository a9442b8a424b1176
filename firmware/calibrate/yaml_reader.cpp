#include "calibrate/yaml_reader.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <set>

#include "base/one_line.h"
#include "base/startup_error.h"

namespace ninedot {

void YamlReader::refuse(const YAML::Node& where, const std::string& what) const {
  const YAML::Mark mark = where.Mark();
  throw StartupError(ExitStatus::kWrongUsage,
                     one_line(fmt::format("{}:{}: {}", name_, mark.is_null() ? 1 : mark.line + 1, what)));
}

YAML::Node YamlReader::need(const YAML::Node& map, const char* key) const {
  const YAML::Node node = map[key];
  if (!node) refuse(map, fmt::format("'{}' is missing", key));
  return node;
}

void YamlReader::refuse_repeated_keys(const YAML::Node& map) const {
  std::set<std::string> keys;
  for (const auto& item : map) {
    if (!item.first.IsScalar()) refuse(item.first, "a key is not a word");
    if (!keys.insert(item.first.Scalar()).second)
      refuse(item.first, fmt::format("'{}' is there twice", item.first.Scalar()));
  }
}

double YamlReader::read_number(const YAML::Node& node, const std::string& what) const {
  if (!node.IsScalar()) refuse(node, fmt::format("{} is not a number", what));
  std::string_view text = node.Scalar();
  if (text.starts_with('+')) text.remove_prefix(1);
  double number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(number))
    refuse(node, fmt::format("{} is '{}', not a finite number", what, node.Scalar()));
  return number;
}

std::vector<double> YamlReader::read_matrix(const YAML::Node& map, const char* key) const {
  const YAML::Node node = need(map, key);
  const YAML::Node list = node.IsMap() ? node["data"] : node;
  if (!list || !list.IsSequence()) refuse(node, fmt::format("{} has no list 'data'", key));
  std::vector<double> numbers;
  for (const YAML::Node& item : list)
    numbers.push_back(read_number(item, fmt::format("{}, number {}", key, numbers.size() + 1)));
  if (node.IsMap() && node["rows"] && node["cols"]) {
    const double rows = read_number(node["rows"], fmt::format("{}, rows", key));
    const double cols = read_number(node["cols"], fmt::format("{}, cols", key));
    if (rows * cols != static_cast<double>(numbers.size()))
      refuse(node, fmt::format("{} has {} numbers, but rows x cols is {} x {}", key, numbers.size(), rows, cols));
  }
  return numbers;
}

}  // namespace ninedot
