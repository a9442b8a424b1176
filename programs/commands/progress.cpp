#include "programs/commands/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <chrono>

#include "programs/display/redrawn_lines.h"

namespace ninedot {

using namespace std::chrono_literals;

Progress::Progress() : terminal_(can_redraw(STDERR_FILENO)) {}

bool Progress::is_due() const noexcept { return terminal_ && mono_now() - shown_at_ >= 100ms; }

void Progress::show(std::string_view words) {
  if (!is_due()) return;
  shown_at_ = mono_now();
  // Without wrapping (ECMA-48): what a narrow window can't show is cut, where it would else begin a line each time.
  fmt::print(stderr, "\r\x1b[K\x1b[?7l{}\x1b[?7h", words);
}

void Progress::clear() {
  if (terminal_) fmt::print(stderr, "\r\x1b[K");
}

}  // namespace ninedot
