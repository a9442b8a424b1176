#pragma once
/// One register as the table of register_map.h describes it.
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>

namespace ninedot {

/// How a register's words are to be read. Two words: the high word first (float32: as configured).
enum class RegisterType : std::uint8_t { kU16, kI16, kU32, kI32, kF32, kBits16, kCounter16, kCounter32 };
enum class RegisterAccess : std::uint8_t { kRead, kReadWrite };

struct RegisterEntry {
  std::uint16_t address;
  std::string_view name;
  RegisterType type;
  double scale;           ///< one step, in `unit`; the default where `scale_is_configured`
  std::string_view unit;  ///< empty: a plain number
  std::int64_t lowest;    ///< range in steps: values beyond saturate there (counters wrap)
  std::int64_t highest;   ///< the range's other end, in steps
  RegisterAccess access;
  std::string_view meaning;
  bool scale_is_configured = false;

  constexpr std::uint16_t words() const noexcept {
    return type == RegisterType::kU32 || type == RegisterType::kI32 || type == RegisterType::kF32 ||
                   type == RegisterType::kCounter32
               ? 2
               : 1;
  }
};

namespace register_ranges {
inline constexpr std::int64_t kU16Max = 0xFFFF;
inline constexpr std::int64_t kI16Max = 0x7FFF;  // -32768 is kept for "unknown"
inline constexpr std::int64_t kU32Max = 0xFFFFFFFF;
inline constexpr std::int64_t kI32Max = 0x7FFFFFFF;  // -2147483648 is kept for "unknown"
}  // namespace register_ranges

}  // namespace ninedot
