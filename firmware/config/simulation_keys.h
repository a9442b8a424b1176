#pragma once
/// The keys of [simulation] and its tables, and what they must fulfil together.
#include <span>

#include "config/config_checks.h"
#include "config/config_reference.h"

namespace ninedot {

/// A part of config_keys().
std::span<const ConfigKey> simulation_keys();

/// Way-points that do not follow each other in time, intervals that end before they begin, a head that starts beyond
/// its range, and a simulated camera without a robot.
void check_simulation(const Config& config, ConfigProblems& problems);

}  // namespace ninedot
