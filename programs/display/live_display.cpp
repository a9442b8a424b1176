#include "programs/display/live_display.h"

#include <fmt/format.h>

#include <utility>

#include "programs/display/status_view.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

constexpr auto kTablePeriod = 250ms;
constexpr auto kLinePeriod = 1s;

}  // namespace

LiveDisplay::LiveDisplay(std::FILE* out, std::vector<std::string> footer)
    : lines_(fileno(out)), footer_(std::move(footer)), draws_(lines_.is_terminal()) {}

bool LiveDisplay::is_due(MonoTime now) const noexcept {
  return shown_at_ == MonoTime{} || now - shown_at_ >= (draws_ ? kTablePeriod : kLinePeriod);
}

void LiveDisplay::show(const RegisterReader& registers, std::span<const std::string> clients, MonoTime now) {
  if (!is_due(now)) return;
  shown_at_ = now;
  if (!draws_)
    lines_.print(status_line(registers) + "\n");
  else
    draws_ = lines_.draw(table(registers, clients));  // a smaller window than this shows plain lines from now on
}

std::string LiveDisplay::table(const RegisterReader& registers, std::span<const std::string> clients) const {
  std::string text = status_table(registers);
  for (const std::string& client : clients) text += fmt::format("             {}\n", client);
  for (const std::string& line : footer_) text += line + '\n';
  return text;
}

void LiveDisplay::make_room() {
  if (lines_.make_room()) shown_at_ = {};
}

}  // namespace ninedot
