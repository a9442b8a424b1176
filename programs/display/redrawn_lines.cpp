#include "programs/display/redrawn_lines.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>

#include "drivers/posix/print_patiently.h"

namespace ninedot {
namespace {

// ECMA-48: no wrapping while the lines are drawn, erase to the end of the line, erase below.
constexpr const char* kWrapOff = "\x1b[?7l";
constexpr const char* kWrapOn = "\x1b[?7h";
constexpr const char* kEraseLine = "\x1b[K";
constexpr const char* kEraseBelow = "\x1b[J";

std::string cursor_up(std::size_t lines) { return lines == 0 ? std::string() : fmt::format("\x1b[{}A\r", lines); }

}  // namespace

RedrawnLines::RedrawnLines(int fd) noexcept : fd_(fd), terminal_(isatty(fd) == 1) {}

bool RedrawnLines::fits(std::size_t lines) const noexcept {
  winsize size{};
  return ioctl(fd_, TIOCGWINSZ, &size) != 0 || size.ws_row == 0 || size.ws_row > lines;
}

bool RedrawnLines::draw(std::string_view text) {
  const auto lines = static_cast<std::size_t>(std::ranges::count(text, '\n'));
  if (!fits(lines)) return false;
  std::string frame = kWrapOff + cursor_up(drawn_lines_);
  for (const char c : text) {
    if (c == '\n') frame += kEraseLine;
    frame += c;
  }
  frame += kEraseBelow;
  frame += kWrapOn;
  drawn_lines_ = lines;
  print(frame);
  return true;
}

bool RedrawnLines::make_room() {
  if (drawn_lines_ == 0) return false;
  print(cursor_up(drawn_lines_) + kEraseBelow);
  drawn_lines_ = 0;
  return true;
}

void RedrawnLines::print(std::string_view text) {
  is_broken_ = print_patiently(fd_, text, std::chrono::nanoseconds(0)) == Printed::kBroken;
}

}  // namespace ninedot
