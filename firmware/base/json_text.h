#pragma once
/// Texts in JSON.
#include <string>
#include <string_view>

namespace ninedot {

/// A text as JSON has it, with its quotes; what is no UTF-8 is passed on as it is, control characters are escaped.
/// Memory: allocates. Threads: pure.
inline std::string json_text(std::string_view text) {
  constexpr std::string_view kDigits = "0123456789abcdef";
  std::string quoted = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\')
      quoted += {'\\', c};
    else if (code < 0x20)
      quoted.append("\\u00") += {kDigits[code >> 4U], kDigits[code & 0xFU]};
    else
      quoted += c;
  }
  return quoted + '"';
}

}  // namespace ninedot
