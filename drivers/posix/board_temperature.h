#pragma once
/// How hot the board is.

namespace ninedot {

/// Degrees Celsius of the kernel's first thermal zone (on single-board computers: the processor); NaN where there is
/// none. Reads a file: not for the frame path.
double read_board_temperature(const char* path = "/sys/class/thermal/thermal_zone0/temp") noexcept;

}  // namespace ninedot
