#pragma once
/// From a driver's time stamp to the middle of the exposure, on CLOCK_MONOTONIC.
#include <chrono>

#include "base/mono_time.h"

namespace ninedot {

/// Which instant a stamp means.
enum class StampPoint {
  kStartOfExposure,  ///< V4L2_BUF_FLAG_TSTAMP_SRC_SOE, libcamera's SensorTimestamp: of the first row
  kEndOfFrame,       ///< V4L2_BUF_FLAG_TSTAMP_SRC_EOF: the last pixel has arrived
};

struct ShutterTiming {
  std::chrono::nanoseconds exposure{0};  ///< 0 = unknown
  /// From the end of the exposure to the last pixel. Global shutter: the whole read-out; rolling shutter: half of it
  /// makes the stamp that of the picture's middle row.
  std::chrono::nanoseconds readout{0};
};

/// start of exposure: t + exposure / 2; end of frame: t - readout - exposure / 2.
constexpr MonoTime middle_of_exposure(MonoTime stamp, StampPoint point, const ShutterTiming& timing) noexcept {
  return point == StampPoint::kStartOfExposure ? stamp + timing.exposure / 2
                                               : stamp - timing.readout - timing.exposure / 2;
}

/// A stamp from the future, or older than any buffer may be, is a driver's mistake: then the instant of arrival counts.
/// Four buffers of a camera at 2 Hz.
inline constexpr std::chrono::seconds kOldestStamp{2};
constexpr bool is_plausible_stamp(MonoTime stamp, MonoTime now) noexcept {
  // Not by their difference, which has no room for a stamp that wrapped at 2^63 ns.
  return stamp <= now && stamp >= now - kOldestStamp;
}

/// A kernel's stamp; MonoTime::max(), which is never plausible, where nanoseconds have no room for it.
/// \param since_boot, fraction  as in timeval: [s] and [us]
constexpr MonoTime stamp_of(std::chrono::seconds since_boot, std::chrono::microseconds fraction) noexcept {
  using std::chrono::seconds;
  const bool has_room =
      since_boot >= seconds(0) && since_boot < std::chrono::floor<seconds>(MonoTime::max().time_since_epoch());
  return has_room ? MonoTime(since_boot + fraction) : MonoTime::max();
}

/// CLOCK_BOOTTIME - CLOCK_MONOTONIC: the time spent in suspend. >= 0
std::chrono::nanoseconds read_suspended_time() noexcept;

/// libcamera documents SensorTimestamp as CLOCK_BOOTTIME, and some pipelines pass on the kernel's CLOCK_MONOTONIC. The
/// two differ by the time spent in suspend: the documented meaning is taken unless it is not plausible and the other
/// is. \return  `now` when neither is
MonoTime monotonic_from_sensor_timestamp(std::chrono::nanoseconds stamp, std::chrono::nanoseconds suspended,
                                         MonoTime now) noexcept;

}  // namespace ninedot
