#pragma once
/// How a sensor counts time: in pixel clocks and lines.
///
///     line     (width + horizontal blanking) / pixel rate       exposure  so many lines
///     frame    (height + vertical blanking) lines               rate      1 / frame
///
/// Kernel documentation, "Writing camera sensor drivers", section "Raw camera sensors".
#include <chrono>
#include <cmath>

namespace ninedot {

struct SensorTiming {
  double pixel_rate_hz = 0;  ///< V4L2_CID_PIXEL_RATE; 0: the sensor does not tell, and nothing below is known
  int line_px = 0;           ///< pixel clocks of one line, its blanking included
  int frame_lines = 0;       ///< lines of one frame, those blank included

  bool is_known() const noexcept { return pixel_rate_hz > 0 && line_px > 0 && frame_lines > 0; }
  /// \param count  how many lines
  std::chrono::nanoseconds of_lines(double count) const noexcept {
    return std::chrono::nanoseconds(std::llround(1e9 * count * line_px / pixel_rate_hz));
  }
  /// From one line to the next: of a rolling shutter the rows' distance in time.
  std::chrono::nanoseconds line_time() const noexcept { return of_lines(1); }
  std::chrono::nanoseconds frame_period() const noexcept { return of_lines(frame_lines); }
  /// \return  how many lines, not rounded
  double lines_in(std::chrono::nanoseconds time) const noexcept {
    return 1e-9 * static_cast<double>(time.count()) * pixel_rate_hz / line_px;
  }
};

}  // namespace ninedot
