#include "programs/commands/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>

namespace ninedot {

using namespace std::chrono_literals;

Progress::Progress() : terminal_(isatty(STDERR_FILENO) == 1) {}

bool Progress::is_due() const noexcept { return terminal_ && mono_now() - shown_at_ >= 100ms; }

void Progress::show(std::string_view words) {
  if (!is_due()) return;
  shown_at_ = mono_now();
  fmt::print(stderr, "\r\x1b[K{}", words);
}

void Progress::clear() {
  if (terminal_) fmt::print(stderr, "\r\x1b[K");
}

}  // namespace ninedot
