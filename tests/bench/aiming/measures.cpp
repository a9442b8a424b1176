#include "tests/bench/aiming/measures.h"

#include <algorithm>
#include <cmath>

#include "base/contract.h"
#include "base/units.h"

namespace ninedot::bench {
namespace {

double error_deg(const SimulationRow& row) { return row.truth.centre_error_rad * kDegPerRad; }

}  // namespace

CentreErrors centre_errors(const Rows& rows, double from_s, double to_s) {
  CentreErrors errors;
  int count = 0;
  for (const SimulationRow& row : rows) {
    if (row.truth.t_s < from_s || row.truth.t_s > to_s) continue;
    ++count;
    errors.rms_deg += error_deg(row) * error_deg(row);
    errors.largest_deg = std::max(errors.largest_deg, error_deg(row));
    errors.in_view += row.truth.visible ? 1 : 0;
  }
  EXPECTS(count > 0);
  errors.rms_deg = std::sqrt(errors.rms_deg / count);
  errors.in_view /= count;
  return errors;
}

std::optional<double> settled_s(const Rows& rows, double bound_deg) {
  std::optional<double> since_s;
  for (const SimulationRow& row : rows) {
    if (error_deg(row) > bound_deg)
      since_s.reset();
    else if (!since_s)
      since_s = row.truth.t_s;
  }
  return since_s;
}

double overshoot(const Rows& rows, double target_deg) {
  const double way_deg = target_deg - rows.front().truth.head.pan_rad * kDegPerRad;
  double beyond = 0;
  for (const SimulationRow& row : rows)
    beyond = std::max(beyond, (row.truth.head.pan_rad * kDegPerRad - target_deg) / way_deg);
  return beyond;
}

int command_changes(const Rows& rows, double from_s) {
  int changes = 0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const HeadAngles &a = rows[i - 1].command, &b = rows[i].command;
    if (rows[i].truth.t_s >= from_s && (a.pan_rad != b.pan_rad || a.tilt_rad != b.tilt_rad)) ++changes;
  }
  return changes;
}

std::optional<double> first_valid_s(const Rows& rows, double from_s) {
  for (const SimulationRow& row : rows)
    if (row.truth.t_s >= from_s && row.valid) return row.truth.t_s;
  return std::nullopt;
}

const SimulationRow& row_at(const Rows& rows, double from_s) {
  const auto row = std::ranges::find_if(rows, [&](const SimulationRow& r) { return r.truth.t_s >= from_s; });
  EXPECTS(row != rows.end());
  return *row;
}

}  // namespace ninedot::bench
