#pragma once
/// Errors quote what users typed.
#include <string>

namespace ninedot {

/// Control characters become '?', so that one line stays one line.
inline std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = '?';
  return text;
}

}  // namespace ninedot
