#include "drivers/posix/board_identity.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <fstream>
#include <string_view>

namespace ninedot {
namespace {

// Properties of a device tree are longer only by mistake.
constexpr std::size_t kLongest = 64;

/// A file's first line in printable ASCII, without blanks around it. Device trees end it with a zero, DMI with a line
/// feed.
std::string text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text;
  for (char c = 0; text.size() < kLongest && file.get(c) && c != '\0' && c != '\n';)
    if (std::isprint(static_cast<unsigned char>(c)) != 0) text += c;
  const std::size_t first = text.find_first_not_of(' ');
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(' ') + 1 - first);
}

/// Makers of PCs leave their tools' own words in the field.
bool is_serial(const std::string& text) {
  constexpr std::array<std::string_view, 6> kNone{"default string", "none",          "not applicable",
                                                  "not specified",  "system serial", "to be filled"};
  std::string lower = text;
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  return text.find_first_not_of("0 ") != std::string::npos &&
         std::none_of(kNone.begin(), kNone.end(), [&](std::string_view none) { return lower.starts_with(none); });
}

std::string first_told(const std::string& sys, const std::array<const char*, 3>& files,
                       bool (*counts)(const std::string&)) {
  for (const char* const file : files)
    if (std::string text = text_of(sys + file); counts(text)) return text;
  return {};
}

}  // namespace

BoardIdentity read_board_identity(const std::string& sys) {
  // Below /sys/firmware, because a service that sees processes alone in /proc has no /proc/device-tree.
  return {first_told(sys, {"/firmware/devicetree/base/model", "/class/dmi/id/product_name", "/class/dmi/id/board_name"},
                     [](const std::string& text) { return !text.empty(); }),
          first_told(
              sys,
              {"/firmware/devicetree/base/serial-number", "/class/dmi/id/product_serial", "/class/dmi/id/board_serial"},
              is_serial)};
}

}  // namespace ninedot
