#pragma once
/// Figures of a drive through a scenario.
#include <optional>
#include <vector>

#include "programs/simulation/virtual_run.h"

namespace ninedot::bench {

using Rows = std::vector<SimulationRow>;

struct CentreErrors {
  double rms_deg = 0, largest_deg = 0;
  double in_view = 0;  ///< share of the frames that show P9, 0..1
};

/// Of the frames from..to.
CentreErrors centre_errors(const Rows& rows, double from_s, double to_s);

/// When the error has come below a bound for good. Nothing: never.
std::optional<double> settled_s(const Rows& rows, double bound_deg);

/// How far pan goes beyond `target_deg`, seen from where it begins [1]: 0.1 = a tenth of the way to it.
double overshoot(const Rows& rows, double target_deg);

/// How often the head was told another angle from then on.
int command_changes(const Rows& rows, double from_s);

/// The first frame from then on whose pose is valid. Nothing: none is.
std::optional<double> first_valid_s(const Rows& rows, double from_s);

/// The first frame from then on.
const SimulationRow& row_at(const Rows& rows, double from_s);

}  // namespace ninedot::bench
