#pragma once
/// docs/aiming.md and its plots.
#include <array>
#include <functional>
#include <string>
#include <vector>

#include "programs/simulation/pixel_pid.h"

namespace ninedot::bench {

struct AimingFile {
  std::string name;  ///< "aiming.md"
  std::string text;
};

/// Drives through everything. \param note  told what comes next
std::vector<AimingFile> aiming_files(const PidGains& gains, const std::function<void(const std::string&)>& note);

/// The gains with the smallest cost: the mean of the rms errors of a step of 20 deg, over a second and a half, and of a
/// passage at 1 m/s. \param note  told each gain's cost
PidGains tuned_gains(const std::function<void(const std::string&)>& note);

}  // namespace ninedot::bench
