#pragma once
/// How hot the board is.

namespace ninedot {

/// The kernel's first thermal zone (on single-board computers: the processor). Reads a file: not for the frame path.
/// \param path  its file, in thousandths of a degree (Documentation/driver-api/thermal/sysfs-api.rst); a test's own
/// \return  [degC]; NaN where there is none
/// Memory: none. Threads: any; waits for the driver of the sensor.
double read_board_temperature(const char* path = "/sys/class/thermal/thermal_zone0/temp") noexcept;

}  // namespace ninedot
