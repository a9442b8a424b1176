#pragma once
/// Every key of the configuration in one table: the reader, the checks and docs/configuration.md follow from it.
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "config/config.h"

namespace ninedot {

/// position_mm = [x, y, z]
struct PositionSlot {
  double* x_mm;
  double* y_mm;
  double* z_mm;
};

/// Where a key's value goes; the alternative is the key's type.
using ConfigSlot = std::variant<bool*, int*, std::uint16_t*, std::uint32_t*, double*, char*, std::string*,
                                std::vector<std::string>*, PositionSlot, std::vector<AxisPoint>*>;

struct ConfigKey {
  std::string_view table;  ///< "camera"; "landmarks" is the array of tables [[landmarks]]
  std::string_view name;
  std::string_view unit;     ///< empty: none
  double min = 0, max = 0;   ///< [unit] of numbers, both allowed
  std::string_view choices;  ///< of words, separated by '|'; empty: any text
  std::string_view meaning;  ///< one line of Markdown
  /// \param config  for [[landmarks]] its last landmark is meant
  ConfigSlot (*slot)(Config& config);
};

/// In the order of the document; the keys of a table stand together.
std::span<const ConfigKey> config_keys();

/// One line about a table, for the document. Empty: no such table.
std::string_view config_table_meaning(std::string_view table);

/// docs/configuration.md.
std::string format_config_reference();

}  // namespace ninedot
