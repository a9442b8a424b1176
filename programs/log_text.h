#pragma once
/// What a log takes of a text that may quote files of any size.
#include <string>
#include <utility>

#include "base/one_line.h"

namespace ninedot {

/// One line, of 1000 bytes at most: longer ones end in "...", without half a letter of UTF-8 before it. Whoever wants
/// all of it asks `ninedot check`. Threads: any.
inline std::string log_text(std::string text) {
  constexpr std::size_t kLongest_bytes = 1000;
  if (text.size() > kLongest_bytes) {
    std::size_t end = kLongest_bytes - 3;
    while (end > 0 && (static_cast<unsigned char>(text[end]) & 0xC0U) == 0x80U) --end;
    text.resize(end);
    text += "...";
  }
  return one_line(std::move(text));
}

}  // namespace ninedot
