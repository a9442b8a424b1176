#pragma once
/// Every key of the configuration in one table: the reader, the checks and docs/configuration.md follow from it.
#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "config/config.h"

namespace ninedot {

/// Where a key's value goes; the alternative is the key's type.
using ConfigSlot =
    std::variant<bool*, int*, std::uint16_t*, std::uint32_t*, double*, std::optional<double>*, char*, std::string*,
                 std::vector<std::string>*, std::array<double, 3>*, std::optional<std::array<double, 3>>*,
                 std::optional<std::array<double, 4>>*, std::vector<AxisPoint>*>;

struct ConfigKey {
  std::string_view table;  ///< "camera"; "landmarks" is the array of tables [[landmarks]]; empty: above all tables
  std::string_view name;
  std::string_view unit;     ///< empty: none
  double min = 0, max = 0;   ///< [unit] of numbers, both allowed
  std::string_view choices;  ///< of words, separated by '|'; empty: any text
  std::string_view meaning;  ///< one line of Markdown
  /// \param config  in a list of tables, as [[landmarks]], the last one is meant
  ConfigSlot (*slot)(Config& config);
};

/// In the order of the document; the keys of a table stand together.
std::span<const ConfigKey> config_keys();

/// One line about a table, for the document. Empty: no such table.
std::string_view config_table_meaning(std::string_view table);

/// Whether a file may hold several of a table: [[landmarks]].
bool is_config_list(std::string_view table) noexcept;

/// What a key may be, and what it is where the file does not say, as docs/configuration.md has it.
std::string config_key_range(const ConfigKey& key);
std::string config_key_default(const ConfigKey& key);

/// docs/configuration.md.
std::string format_config_reference();

}  // namespace ninedot
