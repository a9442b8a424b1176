#pragma once
/// What the head's thread tells the frame loop, after each of its steps.
#include <chrono>
#include <cstdint>
#include <optional>
#include <type_traits>

#include "aim/head_track.h"
#include "base/servo_health.h"
#include "base/zoom_stand.h"
#include "report/report.h"

namespace ninedot {

struct HeadSnapshot {
  HeadTrack track;
  AimState state = AimState::kHold;
  bool limited = false, failed = false, inhibited = false;  ///< as in ReportHead
  std::uint32_t order = 0;                                  ///< AimOrder::number of the order that it follows
  OrderProgress progress = OrderProgress::kNone;            ///< of that order
  std::uint32_t losses = 0;                                 ///< HeadState::losses
  ServoHealth servos;                                       ///< HeadState::servos
  std::optional<ZoomStand> zoom;                            ///< HeadState::zoom
  std::chrono::nanoseconds sweep{};  ///< how long the sweep of kSearch takes as a whole, from where it began
  std::chrono::nanoseconds pulse_error_p99{}, pulse_error_max{};
};
static_assert(std::is_trivially_copyable_v<HeadSnapshot>);

}  // namespace ninedot
