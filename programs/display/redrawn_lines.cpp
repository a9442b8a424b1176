#include "programs/display/redrawn_lines.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>

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

bool can_redraw(int fd) noexcept {
  const char* const kind = std::getenv("TERM");
  return isatty(fd) == 1 && (kind == nullptr || std::string_view(kind) != "dumb");
}

std::size_t columns_of(int fd) noexcept {
  winsize size{};
  return ioctl(fd, TIOCGWINSZ, &size) != 0 || size.ws_col == 0 ? 80 : size.ws_col;
}

RedrawnLines::RedrawnLines(int fd) noexcept : fd_(fd), terminal_(can_redraw(fd)) {}

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
