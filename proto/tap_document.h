#pragma once
/// The tap's layout in words, from the structures themselves: the tables of docs/tap.md.
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace ninedot {

/// One member of a structure.
struct TapField {
  std::string_view name;
  std::string_view type;   ///< u16, u32, u64, i64, f32, f64, char; with [N] where there are several
  std::size_t offset = 0;  ///< [bytes] from the structure's start
  std::size_t size = 0;    ///< [bytes]
  std::string_view meaning;
};

struct TapStructure {
  std::string_view name, meaning;
  std::size_t size = 0;  ///< [bytes]
  std::span<const TapField> fields;
};

/// In the order of the document.
std::span<const TapStructure> tap_structures();

/// The tables of docs/tap.md, between its two marks.
std::string tap_layout_markdown();

}  // namespace ninedot
