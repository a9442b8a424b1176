#include "programs/display/live_display.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>

#include "drivers/posix/print_patiently.h"
#include "programs/display/status_view.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

constexpr auto kTablePeriod = 250ms;
constexpr auto kLinePeriod = 1s;

// ECMA-48: no wrapping while the table is drawn, erase to the end of the line, erase below.
constexpr const char* kWrapOff = "\x1b[?7l";
constexpr const char* kWrapOn = "\x1b[?7h";
constexpr const char* kEraseLine = "\x1b[K";
constexpr const char* kEraseBelow = "\x1b[J";

std::string cursor_up(std::size_t lines) { return lines == 0 ? std::string() : fmt::format("\x1b[{}A\r", lines); }

}  // namespace

LiveDisplay::LiveDisplay(std::FILE* out, std::vector<std::string> footer)
    : out_(out), footer_(std::move(footer)), terminal_(isatty(fileno(out)) == 1) {}

bool LiveDisplay::fits(std::size_t lines) const noexcept {
  winsize size{};
  return ioctl(fileno(out_), TIOCGWINSZ, &size) != 0 || size.ws_row == 0 || size.ws_row > lines;
}

bool LiveDisplay::is_due(MonoTime now) const noexcept {
  return shown_at_ == MonoTime{} || now - shown_at_ >= (terminal_ ? kTablePeriod : kLinePeriod);
}

void LiveDisplay::show(const RegisterReader& registers, std::span<const std::string> clients, MonoTime now) {
  if (!is_due(now)) return;
  shown_at_ = now;
  if (terminal_) {
    draw(registers, clients);
  } else {
    print(status_line(registers) + "\n");
  }
}

void LiveDisplay::print(std::string_view text) {
  // Whoever looks away, or has stopped the terminal, holds nobody up.
  is_broken_ = print_patiently(fileno(out_), text, std::chrono::nanoseconds(0)) == Printed::kBroken;
}

void LiveDisplay::draw(const RegisterReader& registers, std::span<const std::string> clients) {
  std::string text = status_table(registers);
  for (const std::string& client : clients) text += fmt::format("             {}\n", client);
  for (const std::string& line : footer_) text += line + '\n';

  const auto lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
  if (!fits(lines)) {
    terminal_ = false;  // a smaller window than this shows plain lines from now on
    return;
  }
  std::string frame = kWrapOff + cursor_up(drawn_lines_);
  for (const char c : text) {
    if (c == '\n') frame += kEraseLine;
    frame += c;
  }
  frame += kEraseBelow;
  frame += kWrapOn;
  drawn_lines_ = lines;
  print(frame);
}

void LiveDisplay::make_room() {
  if (drawn_lines_ == 0) return;
  print(cursor_up(drawn_lines_) + kEraseBelow);
  drawn_lines_ = 0;
  shown_at_ = {};
}

}  // namespace ninedot
