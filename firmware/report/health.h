#pragma once
/// How the service is doing beside what each report says: published about once a second and at every change.
#include <chrono>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "base/mono_time.h"
#include "base/servo_health.h"

namespace ninedot {

/// Plain numbers. Written by the frame loop alone.
struct Health {
  MonoTime started_at{};
  double frame_rate_hz = 0;          ///< processed frames per second, over the last period
  MonoTime rate_holds_until{};       ///< afterwards nothing is known of the rate but that no news came: 0
  std::uint32_t frames_flagged = 0;  ///< marked as damaged by the camera itself; never lent to the frame loop
  std::uint32_t camera_restarts = 0;
  std::uint32_t head_losses = 0;  ///< how often the head fell silent or its line vanished
  ServoHealth servos;             ///< what the head's smart servos tell
  bool has_latency = false;       ///< a frame has been processed: the four below mean something
  std::chrono::nanoseconds latency_median{}, latency_p99{}, latency_p999{}, latency_max{};
  std::chrono::nanoseconds pulse_error_p99{}, pulse_error_max{};  ///< of software-made servo pulses' widths, else 0
  double temperature_degC = std::numeric_limits<double>::quiet_NaN();  ///< of the board, NaN where unknown
  bool realtime = false;                                               ///< the frame loop runs under SCHED_FIFO
  bool memory_locked = false;
};
static_assert(std::is_trivially_copyable_v<Health>);

}  // namespace ninedot
