#include "programs/web/viewers.h"

#include <algorithm>
#include <cctype>

namespace ninedot {

Viewers::Seat* Viewers::seat_of(std::string_view viewer, MonoTime now) {
  const auto is_taken = [&](const Seat& seat) { return !seat.viewer.empty() && now - seat.seen_at < kLeavesAfter; };
  auto seat =
      std::find_if(seats_.begin(), seats_.end(), [&](const Seat& s) { return is_taken(s) && s.viewer == viewer; });
  if (seat == seats_.end()) {
    seat = std::find_if_not(seats_.begin(), seats_.end(), is_taken);
    if (seat == seats_.end()) return nullptr;
    *seat = {std::string(viewer), now, 0};
  }
  seat->seen_at = now;
  return &*seat;
}

std::size_t Viewers::count(MonoTime now) const noexcept {
  return static_cast<std::size_t>(std::count_if(seats_.begin(), seats_.end(), [&](const Seat& seat) {
    return !seat.viewer.empty() && now - seat.seen_at < kLeavesAfter;
  }));
}

bool Viewers::is_name(std::string_view viewer) noexcept {
  return viewer.size() >= 8 && viewer.size() <= 32 &&
         std::all_of(viewer.begin(), viewer.end(), [](unsigned char c) { return std::isalnum(c) != 0; });
}

}  // namespace ninedot
