#include "drivers/posix/text_file.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <span>
#include <vector>

#include "base/startup_error.h"
#include "drivers/posix/whole_file.h"

namespace ninedot {

std::string read_text_file(const std::string& path, std::size_t max_bytes) {
  std::vector<std::uint8_t> bytes(max_bytes);
  const Result<std::size_t> count = read_whole_file(path.c_str(), bytes);
  if (!count) {
    const int os_errno = count.error().os_errno;
    if (os_errno == 0) throw StartupError(ExitStatus::kWrongUsage, fmt::format("{}: {}", path, count.error().text));
    throw StartupError(ExitStatus::kWrongUsage,
                       os_errno == EFBIG
                           ? fmt::format("{}: longer than {} bytes; is it the right file?", path, max_bytes)
                           : fmt::format("{}: {}: {}", path, count.error().text, std::strerror(os_errno)));
  }
  return std::string(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(*count));
}

}  // namespace ninedot
