#pragma once
/// Who looks at the page now: a fixed number of seats, each given up by itself when nobody asks from it any more.
#include <array>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/mono_time.h"

namespace ninedot {

/// Threads: one at a time.
class Viewers {
 public:
  static constexpr std::size_t kSeats = 16;
  /// A page asks ten times a second; a phone in a pocket or a closed window does not.
  static constexpr std::chrono::seconds kLeavesAfter{5};

  struct Seat {
    std::string viewer;  ///< the name that the page chose for itself
    MonoTime seen_at{};
    std::uint64_t served = 0;  ///< the newest message that it was given [1]
    bool wants_every = false;  ///< by its last request: each frame, not some
  };

  /// The seat of this viewer, a free one if it has none yet; null: all are taken.
  Seat* seat_of(std::string_view viewer, MonoTime now);
  /// How many look. \param now  the moment that is meant
  std::size_t count(MonoTime now) const noexcept;

  /// Whether one of them wants every frame.
  bool want_every(MonoTime now) const noexcept;

  /// A name as pages choose it: 8 to 32 letters and digits.
  static bool is_name(std::string_view viewer) noexcept;

 private:
  static bool is_taken(const Seat& seat, MonoTime now) noexcept;

  std::array<Seat, kSeats> seats_;
};

}  // namespace ninedot
