#include "programs/web/viewers.h"

#include <algorithm>
#include <cctype>

namespace ninedot {

Viewers::Seat* Viewers::seat_of(std::string_view viewer, MonoTime now) {
  auto seat =
      std::find_if(seats_.begin(), seats_.end(), [&](const Seat& s) { return is_taken(s, now) && s.viewer == viewer; });
  if (seat == seats_.end()) {
    seat = std::find_if_not(seats_.begin(), seats_.end(), [&](const Seat& s) { return is_taken(s, now); });
    if (seat == seats_.end()) return nullptr;
    *seat = {std::string(viewer), now};
  }
  seat->seen_at = now;
  return &*seat;
}

std::size_t Viewers::count(MonoTime now) const noexcept {
  return static_cast<std::size_t>(
      std::count_if(seats_.begin(), seats_.end(), [&](const Seat& seat) { return is_taken(seat, now); }));
}

bool Viewers::want_every(MonoTime now) const noexcept {
  return std::any_of(seats_.begin(), seats_.end(),
                     [&](const Seat& seat) { return is_taken(seat, now) && seat.wants_every; });
}

bool Viewers::is_taken(const Seat& seat, MonoTime now) noexcept {
  return !seat.viewer.empty() && now - seat.seen_at < kLeavesAfter;
}

bool Viewers::is_name(std::string_view viewer) noexcept {
  return viewer.size() >= 8 && viewer.size() <= 32 &&
         std::all_of(viewer.begin(), viewer.end(), [](unsigned char c) { return std::isalnum(c) != 0; });
}

}  // namespace ninedot
