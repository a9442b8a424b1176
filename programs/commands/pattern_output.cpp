#include "programs/commands/pattern_output.h"

#include <fmt/core.h>

#include <cstdint>
#include <cstring>

#include "base/startup_error.h"
#include "drivers/posix/whole_file.h"

namespace ninedot {

void write_pattern(std::span<const PatternPage> pages, const std::string& path) {
  const auto ends_with = [&](std::string_view ending) { return path.size() > ending.size() && path.ends_with(ending); };
  const bool is_svg = ends_with(".svg");
  if (!is_svg && !ends_with(".pdf"))
    throw StartupError(ExitStatus::kWrongUsage, fmt::format("--out {}: end the file's name with .svg or .pdf", path));
  if (is_svg && pages.size() > 1)
    throw StartupError(
        ExitStatus::kWrongUsage,
        fmt::format("--out {}: an SVG has one page, and these are {}: write a .pdf", path, pages.size()));
  const std::string file = is_svg ? encode_svg(pages.front()) : encode_pdf(pages);

  const auto bytes = std::span(reinterpret_cast<const std::uint8_t*>(file.data()), file.size());
  if (const auto written = write_whole_file(path, bytes); !written)
    throw StartupError(ExitStatus::kWorkFailed,
                       fmt::format("{}: {}: {}", path, written.error().text, std::strerror(written.error().os_errno)));
}

}  // namespace ninedot
