#include "config/toml_text.h"

#include <algorithm>
#include <cctype>
#include <cstddef>

namespace ninedot {
namespace {

bool is_of_word(char c) {
  return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-' || c == '+' || c == '.';
}

/// Dots that may be a key's: all but one between the digits of a number. At least half of those that are.
std::size_t dots_of_keys(std::string_view line) {
  std::size_t dots = 0;
  for (std::size_t i = 0; i < line.size();) {
    const auto* const end = std::find_if_not(line.begin() + i, line.end(), is_of_word);
    const std::string_view word(line.begin() + i, end);
    const auto count = static_cast<std::size_t>(std::count(word.begin(), word.end(), '.'));
    if (count != 1 || word.front() == '.' || word.back() == '.') dots += count;
    i += word.size() + 1;
  }
  return dots;
}

/// The library goes one call deeper for each dot of a key, and has no bound of its own: a hundred thousand of them end
/// the process. Lists within lists it does bound, at 256. So this text needs 2 * (258 * kFewDots + kMostDots) calls at
/// most, of 270 bytes each (measured): half of a thread's stack.
/// \return  the line at which it is too much; 0: it is not
int find_endless_keys(std::string_view text) {
  constexpr std::size_t kFewDots = 16, kMostDots = 4096;
  std::size_t dots = 0;
  for (int line = 1; !text.empty(); ++line) {
    const std::string_view own = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), own.size() + 1));
    const std::size_t count = dots_of_keys(own);
    if (count > kFewDots) dots += count;
    if (dots > kMostDots) return line;
  }
  return 0;
}

}  // namespace

std::optional<toml::table> parse_toml(std::string_view text, const std::string& name, ConfigProblems& problems) {
  if (const int line = find_endless_keys(text); line != 0) {
    problems.add(line, "more dots than any key has: is that a configuration?");
    problems.can_be_read = false;
    return std::nullopt;
  }
  try {
    return toml::table(toml::parse(text, name));
  } catch (const toml::parse_error& error) {
    problems.add(static_cast<int>(error.source().begin.line), std::string(error.description()));
    problems.can_be_read = false;
    return std::nullopt;
  }
}

}  // namespace ninedot
