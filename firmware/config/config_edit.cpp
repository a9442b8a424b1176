#include "config/config_edit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>
#include <utility>

#include "base/startup_error.h"
#include "config/config_checks.h"
#include "config/toml_text.h"

namespace ninedot {
namespace {

toml::table read(std::string_view text, const std::string& name) {
  ConfigProblems problems;
  std::optional<toml::table> root = parse_toml(text, name, problems);
  if (!root) throw StartupError(ExitStatus::kWrongUsage, problem_text(name, problems.list.front()));
  return std::move(*root);
}

/// Of a line and a column as the library counts them, in characters. \return  the byte
std::size_t place_of(std::string_view text, const toml::source_position& at) {
  std::size_t place = 0;
  for (auto line = at.line; line > 1; --line) place = text.find('\n', place) + 1;
  const auto continues = [&](std::size_t i) { return i < text.size() && (text[i] & 0xC0) == 0x80; };
  for (auto column = at.column; column > 1; --column) do
      ++place;
    while (continues(place));
  return place;
}

std::string_view text_at(std::string_view text, const toml::source_region& region) {
  const std::size_t begin = place_of(text, region.begin);
  return text.substr(begin, place_of(text, region.end) - begin);
}

/// \return  null: it is not there
const toml::node* find(const toml::table& root, std::string_view table, std::string_view key) {
  return root.at_path(fmt::format("{}.{}", table, key)).node();
}

/// The byte behind the line of a table's own [head]; nothing: it has none.
std::optional<std::size_t> end_of_head(std::string_view text, const toml::table& table) {
  const std::size_t begin = place_of(text, table.source().begin);
  if (begin >= text.size() || text[begin] != '[') return std::nullopt;
  return std::min(text.find('\n', begin), text.size());
}

std::string with_key(std::string text, const KeyText& key, const std::string& name) {
  const toml::table root = read(text, name);
  if (const toml::node* const old = find(root, key.table, key.key)) {
    const std::string_view value = text_at(text, old->source());
    return text.replace(static_cast<std::size_t>(value.data() - text.data()), value.size(), key.value);
  }
  const std::string line = fmt::format("{} = {}", key.key, key.value);
  const toml::table* const table = root.at_path(key.table).as_table();
  if (table == nullptr) return fmt::format("{}{}\n[{}]\n{}\n", text, text.ends_with('\n') ? "" : "\n", key.table, line);
  const std::optional<std::size_t> head = end_of_head(text, *table);
  return head ? text.insert(*head, "\n" + line) : text;
}

/// Whether it says the same as the key's own text.
bool has_key(const toml::table& root, const KeyText& key) {
  const toml::node* const found = find(root, key.table, key.key);
  if (found == nullptr) return false;
  toml::table alone;
  alone.insert("key", *found);
  return alone == read(fmt::format("key = {}", key.value), key.key);
}

void gather_keys(const toml::table& table, const std::string& path, std::string_view text, std::vector<KeyText>& keys) {
  for (const auto& [key, node] : table) {
    const std::string name(key.str());
    if (const toml::table* const inner = node.as_table(); inner != nullptr && !inner->is_inline())
      gather_keys(*inner, path.empty() ? name : path + "." + name, text, keys);
    else if (!path.empty() && !node.is_array_of_tables())
      keys.push_back({path, name, std::string(text_at(text, node.source()))});
  }
}

/// From its [[head]] to the end of the line of its last value: what a comment below it is about is not known.
struct Stretch {
  std::size_t begin = 0, end = 0;  ///< bytes
};

/// \return  begin == end: it has no head of its own
Stretch stretch_of(std::string_view text, const toml::table& table) {
  Stretch stretch{place_of(text, table.source().begin), 0};
  if (!text.substr(std::min(stretch.begin, text.size())).starts_with("[[")) return {};
  stretch.end = stretch.begin;
  for (const auto& [key, node] : table) stretch.end = std::max(stretch.end, place_of(text, node.source().end));
  stretch.end = std::min(text.find('\n', stretch.end), text.size() - 1) + 1;
  const std::size_t line = text.rfind('\n', stretch.begin);
  stretch.begin = line == std::string_view::npos ? 0 : line + 1;
  // The blank line below it goes as well.
  if (text.substr(stretch.end).starts_with('\n')) ++stretch.end;
  return stretch;
}

[[noreturn]] void refuse_landmarks(const std::string& name) {
  throw StartupError(ExitStatus::kWrongUsage,
                     fmt::format("{}: the landmarks can't be taken out of it, and a map takes their place: give each a "
                                 "[[landmarks]] of its own, and its keys below it",
                                 name));
}

std::string without_landmarks(std::string text, const std::string& name) {
  const toml::table root = read(text, name);
  const toml::array* const landmarks = root["landmarks"].as_array();
  if (landmarks == nullptr) return text;
  std::vector<Stretch> stretches;
  for (const toml::node& node : *landmarks) {
    stretches.push_back(node.is_table() ? stretch_of(text, *node.as_table()) : Stretch{});
    if (stretches.back().begin == stretches.back().end) refuse_landmarks(name);
  }
  // From the last one on, so that the others stay where they are.
  std::ranges::sort(stretches, std::greater(), &Stretch::begin);
  for (const Stretch& stretch : stretches) text.erase(stretch.begin, stretch.end - stretch.begin);
  return text;
}

}  // namespace

std::vector<KeyText> keys_of(std::string_view text, const std::string& name) {
  std::vector<KeyText> keys;
  gather_keys(read(text, name), {}, text, keys);
  return keys;
}

std::string with_keys(std::string text, std::span<const KeyText> keys, const std::string& name) {
  for (const KeyText& key : keys) text = with_key(std::move(text), key, name);
  const toml::table root = read(text, name);
  for (const KeyText& key : keys)
    if (!has_key(root, key))
      throw StartupError(ExitStatus::kWrongUsage,
                         fmt::format("{}: '{}' can't be set in it: give [{}] a line of its own, and its keys below it",
                                     name, key.key, key.table));
  return text;
}

std::string with_map_named(std::string text, const std::string& map, const std::string& name) {
  toml::table before = read(text, name);
  text = without_landmarks(std::move(text), name);
  const toml::table root = read(text, name);
  if (const toml::node* const old = root["map"].node()) {
    const std::string_view value = text_at(text, old->source());
    text.replace(static_cast<std::size_t>(value.data() - text.data()), value.size(), map);
  } else {
    text.insert(0, fmt::format("map = {}\n", map));
  }
  // All else says what it said.
  toml::table after = read(text, name);
  const bool has_map = after["map"].value<std::string>() == read("map = " + map, name)["map"].value<std::string>();
  for (toml::table* table : {&before, &after}) table->erase("map");
  before.erase("landmarks");
  if (!has_map || after != before) refuse_landmarks(name);
  return text;
}

}  // namespace ninedot
