#include "drivers/camera/exposure_stamp.h"

#include <ctime>

namespace ninedot {
namespace {

std::chrono::nanoseconds read_clock(clockid_t clock) noexcept {
  timespec time{};
  ::clock_gettime(clock, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

}  // namespace

std::chrono::nanoseconds read_suspended_time() noexcept {
  const auto before = read_clock(CLOCK_MONOTONIC);
  const auto boot = read_clock(CLOCK_BOOTTIME);
  const auto after = read_clock(CLOCK_MONOTONIC);
  // Within the two readings there was no suspend worth speaking of.
  return boot >= before && boot <= after ? std::chrono::nanoseconds{0} : boot - before;
}

MonoTime monotonic_from_sensor_timestamp(std::chrono::nanoseconds stamp, std::chrono::nanoseconds suspended,
                                         MonoTime now) noexcept {
  const MonoTime documented(stamp - suspended);
  if (is_plausible_stamp(documented, now)) return documented;
  const MonoTime undocumented(stamp);
  return is_plausible_stamp(undocumented, now) ? undocumented : now;
}

}  // namespace ninedot
