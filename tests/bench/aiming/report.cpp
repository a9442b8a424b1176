#include "tests/bench/aiming/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "base/units.h"
#include "tests/bench/aiming/line_plot.h"
#include "tests/bench/aiming/measures.h"
#include "tests/bench/aiming/scenarios.h"

namespace ninedot::bench {
namespace {

constexpr const char *kBlue = "#0072B2", *kVermilion = "#D55E00";
constexpr std::array kDelays_ms{10.0, 20.0, 40.0, 70.0, 100.0, 150.0};
constexpr std::array kSpeeds_m_s{0.0, 0.5, 1.0, 2.0, 3.0};

using Note = std::function<void(const std::string&)>;

/// The same scenario by both controllers.
struct Pair {
  Rows servoing, pid;
};

Pair drive_both(const Config& scenario, const PidGains& gains) {
  return {drive(scenario, std::nullopt), drive(scenario, gains)};
}

/// Half of a total delay is the camera's, half the servo's.
Config hobby(double delay_ms) { return base_scenario(ServoKind::kHobby, delay_ms / 2, delay_ms / 2); }

PlotLine error_line(const Rows& rows, const char* name, const char* colour) {
  PlotLine line{name, colour, {}};
  for (const SimulationRow& row : rows)
    line.points.emplace_back(row.truth.t_s, row.truth.centre_error_rad * kDegPerRad);
  return line;
}

std::string error_plot(const Pair& pair, double y_end_deg, std::vector<std::pair<double, double>> grey = {}) {
  return drawn({"time, s",
                "landmark off the centre, deg",
                y_end_deg,
                {error_line(pair.servoing, "servoing", kBlue), error_line(pair.pid, "pid", kVermilion)},
                std::move(grey)});
}

std::string verdict(bool is_reached) { return is_reached ? "yes" : "**no**"; }

/// A requirement, and what each controller makes of it.
struct Reach {
  std::string demand;
  std::function<std::string(const Rows&)> figure;
  std::function<bool(const Rows&)> is_reached;
};

std::string reach_row(const Reach& reach, const Pair& pair) {
  return fmt::format("| {} | {} | {} | {} | {} |\n", reach.demand, reach.figure(pair.servoing),
                     verdict(reach.is_reached(pair.servoing)), reach.figure(pair.pid),
                     verdict(reach.is_reached(pair.pid)));
}

Reach largest_below(const std::string& demand, double from_s, double to_s, double bound_deg) {
  return {demand,
          [=](const Rows& rows) { return fmt::format("{:.2f} deg", centre_errors(rows, from_s, to_s).largest_deg); },
          [=](const Rows& rows) { return centre_errors(rows, from_s, to_s).largest_deg < bound_deg; }};
}

/// When a landmark can be seen again the search may be anywhere: each of these waits finds it elsewhere.
constexpr std::array kLonger_s{0.0, 0.5, 1.0, 1.5, 2.0, 2.5, 3.0};

std::string lost_row(const PidGains& gains, const Note& note) {
  const double bound_s = 2 * sweep_s(hobby(40));
  std::string row = fmt::format(
      "| lost for 5 to 8 s, and 97 deg aside then, maybe just behind the head's back: found again within two rounds of "
      "its search, {:.0f} s |",
      bound_s);
  for (const bool is_pid : {false, true}) {
    double longest_s = 0;
    for (const double longer_s : kLonger_s) {
      note(fmt::format("lost for {} s", kLostTo_s + longer_s - kLostFrom_s));
      const Rows rows = drive(lost(hobby(40), longer_s), is_pid ? std::optional(gains) : std::nullopt);
      const auto found = first_valid_s(rows, kLostTo_s + longer_s);
      longest_s = std::max(longest_s, found ? *found - kLostTo_s - longer_s : 1e9);
    }
    row += longest_s < 1e9 ? fmt::format(" after {:.2f} s at most | {} |", longest_s, verdict(longest_s <= bound_s))
                           : std::string(" never | **no** |");
  }
  return row + "\n";
}

std::string reach_table(const PidGains& gains, const Note& note, std::vector<AimingFile>& files) {
  std::string table = "| to be reached | servoing | reached | pid | reached |\n|---|---|---|---|---|\n";
  note("step of 20 deg");
  const Pair step = drive_both(standing(hobby(40), 20, 3), gains);
  table += reach_row({"hobby servo, 40 ms: from 20 deg off to within 1.5 deg for good, in less than 0.6 s",
                      [](const Rows& rows) {
                        const auto settled = settled_s(rows, 1.5);
                        return settled ? fmt::format("{:.2f} s", *settled) : std::string("never");
                      },
                      [](const Rows& rows) { return settled_s(rows, 1.5).value_or(1e9) < 0.6; }},
                     step);
  table += reach_row({"and beyond it by less than 10 %",
                      [](const Rows& rows) { return fmt::format("{:.0f} %", 100 * overshoot(rows, 0)); },
                      [](const Rows& rows) { return overshoot(rows, 0) < 0.1; }},
                     step);
  files.push_back({"aiming-step.svg", error_plot(step, 25)});

  note("standing still");
  table += reach_row({"hobby servo, a robot that stands: no other command in 10 s, once settled",
                      [](const Rows& rows) { return fmt::format("{} changes", command_changes(rows, 3)); },
                      [](const Rows& rows) { return command_changes(rows, 3) == 0; }},
                     drive_both(standing(hobby(40), 5, 13), gains));

  note("passing at 1 m/s");
  const Config pass = passing(hobby(40), 1);
  const Pair passed = drive_both(pass, gains);
  table += reach_row(largest_below("hobby servo, 40 ms, passing at 1 m/s: never more than 3 deg off", 0,
                                   pass.simulation.duration_s, 3),
                     passed);
  files.push_back({"aiming-pass.svg", error_plot(passed, 12)});

  note("hidden for half a second");
  const double from_s = passing_middle_s(1) - 0.25, to_s = from_s + 0.5;
  const Pair covered = drive_both(hidden(pass, from_s, 0.5), gains);
  table += reach_row({"the same, hidden for 0.5 s in the middle: still in view when it comes back",
                      [=](const Rows& rows) {
                        return fmt::format("{:.1f} deg off", row_at(rows, to_s).truth.centre_error_rad * kDegPerRad);
                      },
                      [=](const Rows& rows) { return row_at(rows, to_s).truth.visible; }},
                     covered);
  files.push_back({"aiming-hidden.svg", error_plot(covered, 40, {{from_s, to_s}})});

  table += lost_row(gains, note);

  note("smart servo");
  const Config smart = base_scenario(ServoKind::kSmart, 20, 20);
  const Pair smart_pass = drive_both(passing(smart, 1), gains);
  table += reach_row(
      largest_below("smart servo, 20 ms and the camera's 20 ms, passing at 1 m/s: never more than 0.5 deg off", 0,
                    pass.simulation.duration_s, 0.5),
      smart_pass);
  table += reach_row(largest_below("the same, from 0.5 s after it has set off", 1.5, pass.simulation.duration_s, 0.5),
                     smart_pass);
  table += reach_row(largest_below("smart servo, standing: never more than 0.2 deg off after 2 s", 2, 6, 0.2),
                     drive_both(standing(smart, 5, 6), gains));
  return table;
}

std::string cell(const CentreErrors& errors) {
  return fmt::format("{:.2f} ({:.1f}){}", errors.rms_deg, errors.largest_deg,
                     errors.in_view < 1 ? fmt::format(", {:.0f} %", 100 * errors.in_view) : "");
}

std::string delay_table(const PidGains& gains, const Note& note, std::vector<AimingFile>& files) {
  std::string table = "| delay | controller |";
  for (const double speed : kSpeeds_m_s) table += fmt::format(" {} m/s |", speed);
  table += "\n|---|---|---|---|---|---|---|\n";
  PlotLine servoing{"servoing", kBlue, {}}, pid{"pid", kVermilion, {}};
  for (const double delay_ms : kDelays_ms) {
    std::string ours = fmt::format("| {} ms | servoing |", delay_ms), theirs = "| | pid |";
    for (const double speed : kSpeeds_m_s) {
      note(fmt::format("{} ms, {} m/s", delay_ms, speed));
      const Config scenario = passing(hobby(delay_ms), speed);
      const Pair pair = drive_both(scenario, gains);
      const CentreErrors a = centre_errors(pair.servoing, 1, scenario.simulation.duration_s);
      const CentreErrors b = centre_errors(pair.pid, 1, scenario.simulation.duration_s);
      ours += fmt::format(" {} |", cell(a));
      theirs += fmt::format(" {} |", cell(b));
      if (speed != 1.0) continue;
      servoing.points.emplace_back(delay_ms, a.rms_deg);
      pid.points.emplace_back(delay_ms, b.rms_deg);
    }
    table += ours + "\n" + theirs + "\n";
  }
  files.push_back(
      {"aiming-delay.svg", drawn({"total delay, ms", "off the centre at 1 m/s, rms, deg", 12, {servoing, pid}, {}})});
  return table;
}

std::string page(const PidGains& gains, const std::string& reach, const std::string& delays) {
  const double forced_deg = unforeseeable_deg(base_scenario(ServoKind::kSmart, 20, 20), 1);
  return fmt::format(R"(# Aiming

How well the head keeps the landmark in the middle of the picture, measured in the closed loop of `ninedot simulate` ([simulation.md](simulation.md)):
pictures, the service's own frame path and head output, and servos with their true dynamics. Made by

    build/release/bin/bench_aiming --out docs/aiming.md

The robot looks at the wall that the landmark hangs on, 1.5 m before it; 640 x 480 px, 48 deg wide, 35 frames a second, noise of 2 grey levels.
*Hobby servo*: 0.17 s for 60 deg, 6000 deg/s^2, a dead band of 1 deg to each side, steps of 0.1 deg. *Smart servo*: the same without dead band. A delay of 40 ms is
20 ms from mid-exposure to the frame's arrival and 20 ms from the command to the servo. Errors are the angle between the optical axis and the middle of P9,
in truth, at each frame.

**servoing** is what the service does. **pid** is a plain PID controller on the pixel error, as one would write it without a model of servo and time, with the
gains {} deg/s per px, {} deg/s per px s and {} deg/s per px/s: those of a grid of 80 with the smallest mean of two rms errors (`bench_aiming --tune`), a step of
20 deg and a passage at 1 m/s with the hobby servo and 40 ms. Both see the same pictures, and may turn at 350 deg/s. The service is told the servo's delay and dead
band, and 4000 deg/s^2.

## What is to be reached

{}
The robot that passes sets off at once, from rest to 1 m/s within nothing, 2.5 m from the landmark: before a frame that shows the motion was exposed, has come and
has moved the servo, the landmark is up to {:.2f} deg off, whatever the controller.

![Off the centre after a step of 20 deg](aiming-step.svg)

![Off the centre while passing at 1 m/s; it begins at 1 s](aiming-pass.svg)

![The same, hidden for half a second](aiming-hidden.svg)

## Delays and speeds

Passing from 53 deg aside to 53 deg at the other side, the hobby servo: rms and, in brackets, the largest error in degrees, from the moment at which the robot
starts off; a third number is the share of the frames with P9 in the picture, where that is not all. At 0 m/s the robot stands 2.5 m from the landmark.

{}
![Off the centre over the delay](aiming-delay.svg)
)",
                     gains.kp_deg_s_px, gains.ki_deg_s2_px, gains.kd_deg_px, reach, forced_deg, delays);
}

}  // namespace

std::vector<AimingFile> aiming_files(const PidGains& gains, const Note& note) {
  std::vector<AimingFile> files;
  const std::string reach = reach_table(gains, note, files);
  const std::string delays = delay_table(gains, note, files);
  files.push_back({"aiming.md", page(gains, reach, delays)});
  return files;
}

}  // namespace ninedot::bench
