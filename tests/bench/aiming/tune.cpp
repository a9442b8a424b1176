// A grid: the gains of a PID controller are few, and whoever tunes one by hand tries no more.
#include <fmt/format.h>

#include <limits>

#include "tests/bench/aiming/measures.h"
#include "tests/bench/aiming/report.h"
#include "tests/bench/aiming/scenarios.h"

namespace ninedot::bench {
namespace {

double cost_deg(const PidGains& gains) {
  const Config base = base_scenario(ServoKind::kHobby, 20, 20);
  const double step_deg = centre_errors(drive(standing(base, 20, 1.5), gains), 0, 1.5).rms_deg;
  const Config pass = passing(base, 1);
  const double pass_deg = centre_errors(drive(pass, gains), 1, pass.simulation.duration_s).rms_deg;
  return (step_deg + pass_deg) / 2;
}

}  // namespace

PidGains tuned_gains(const std::function<void(const std::string&)>& note) {
  PidGains best;
  double lowest_deg = std::numeric_limits<double>::infinity();
  for (const double kp : {0.8, 1.0, 1.2, 1.5})
    for (const double ki : {0.5, 1.0, 2.0, 4.0})
      for (const double kd : {0.0, 0.02, 0.04, 0.06, 0.08}) {
        const PidGains gains{kp, ki, kd};
        const double deg = cost_deg(gains);
        note(fmt::format("kp {:.2f} ki {:.2f} kd {:.3f}: {:.3f} deg", kp, ki, kd, deg));
        if (deg < lowest_deg) lowest_deg = deg, best = gains;
      }
  return best;
}

}  // namespace ninedot::bench
