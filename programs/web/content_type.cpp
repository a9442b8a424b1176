#include <array>
#include <utility>

#include "programs/web/page_files.h"

namespace ninedot {

const char* content_type_of(std::string_view name) noexcept {
  constexpr std::array<std::pair<std::string_view, const char*>, 4> kTypes{{
      {".html", "text/html; charset=utf-8"},
      {".js", "text/javascript; charset=utf-8"},
      {".css", "text/css; charset=utf-8"},
      {".svg", "image/svg+xml"},
  }};
  for (const auto& [ending, type] : kTypes)
    if (name.ends_with(ending)) return type;
  return "text/plain; charset=utf-8";
}

}  // namespace ninedot
