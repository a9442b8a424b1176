#include "tests/bench/accuracy_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>

namespace ninedot::bench {
namespace {

std::string solver_columns(const SolverOutcome& solver, double distance_m) {
  if (solver.poses == solver.wrong) return fmt::format(" - | - | - | - | {} |", solver.wrong);
  return fmt::format(" {} | {:.3f} | {} | {} | {} |", three_digits(1000 * solver.rms_m),
                     100 * solver.rms_m / distance_m, three_digits(solver.rms_ratio), three_digits(solver.nees),
                     solver.wrong);
}

std::string table(const Sweep& sweep) {
  std::string text = fmt::format(
      "| {} | found | bound mm | full mm | % of D | x bound | NEES | wrong | ellipse mm | % of D | x bound | NEES "
      "| wrong |\n|---|---|---|---|---|---|---|---|---|---|---|---|---|\n",
      sweep.varied);
  for (std::size_t i = 0; i < sweep.conditions.size(); ++i) {
    const Condition& condition = sweep.conditions[i];
    const Outcome& outcome = sweep.outcomes[i];
    text += fmt::format("| {} | {}/{} | {} |{}{}\n", condition.label, outcome.found, outcome.trials,
                        three_digits(1000 * outcome.bound_m), solver_columns(outcome.full, condition.distance_m),
                        solver_columns(outcome.ellipse, condition.distance_m));
  }
  return text;
}

// Everything together, for the headline.
struct Total {
  int frames = 0, found = 0, poses = 0, wrong = 0;
  double ratios = 0, nees = 0, least_nees = 1e300, most_nees = 0;
  void add(const Outcome& outcome) {
    frames += outcome.trials, found += outcome.found;
    poses += outcome.full.poses, wrong += outcome.full.wrong;
    const double used = outcome.full.poses - outcome.full.wrong;
    if (used <= 0) return;
    ratios += used * outcome.full.rms_ratio * outcome.full.rms_ratio, nees += used * outcome.full.nees;
    least_nees = std::min(least_nees, outcome.full.nees), most_nees = std::max(most_nees, outcome.full.nees);
  }
  double rms_ratio() const { return std::sqrt(ratios / (poses - wrong)); }
  double mean_nees() const { return nees / (poses - wrong); }
};

std::string headline(const std::vector<Sweep>& sweeps) {
  Total total, first;
  for (const Sweep& sweep : sweeps)
    for (const Outcome& outcome : sweep.outcomes) total.add(outcome);
  for (const Outcome& outcome : sweeps.front().outcomes) first.add(outcome);
  return fmt::format(
      "**Over {}, `full` makes {:.2f} times the smallest error that physics allows (the Cramer-Rao bound, root mean\n"
      "square); over all {} frames of single landmarks {:.2f} times. {:.1f} % of the landmarks are found, {:.1f} % of "
      "the "
      "poses are\n"
      "wrong (the other planar solution, or misnumbered dots). Its covariance: mean NEES {:.1f}, by row {:.1f} to "
      "{:.1f}; 6 is "
      "honest.**\n\n",
      sweeps.front().heading, first.rms_ratio(), total.frames, total.rms_ratio(), 100.0 * total.found / total.frames,
      100.0 * total.wrong / std::max(1, total.poses), total.mean_nees(), total.least_nees, total.most_nees);
}

std::string conditions(int trials) {
  return fmt::format(
      R"(Made by `build/release/bin/accuracy --out docs/accuracy.md` (CMake option `NINEDOT_BENCH`) from {0} rendered frames per
row. The renderer ([tests/support/renderer.h](../tests/support/renderer.h)) shares no projection code with the estimator
and is itself checked against path-traced pictures. That of rooms
([tests/support/room_renderer.h](../tests/support/room_renderer.h)) gives the same bytes where nothing moves; beside
another program's pictures of a room, of a walking camera with motion blur and a rolling shutter, its outlines are within
0.006 px and its grey levels over a sheet within 0.7 (rms). The same command gives the same numbers.

## Conditions

The default landmark (sheet of 210 mm, ring of 80 mm radius), 640 x 480 px, fx = fy = 720 px, point spread 0.5 px, sRGB
curve, noise of 2 grey levels at level 128. Where a table does not say otherwise: 1.5 m away, 25 degrees tilted, in the
middle of the picture within a degree, seen from any side, rolled by up to 15 degrees, nothing hidden, even light, a
blotchy wall. Single frames: full search each time, no pose of a frame before to help with the ambiguity. `ellipse` uses
the camera's own calibration, without off-line constants.

- *bound*: Cramer-Rao bound of the position, the three axes together, with paper, ink and blur unknown
  ([tests/bench/crlb.h](../tests/bench/crlb.h)). It takes the light as even.
- *mm*, *% of D*: root mean square error of the position, in mm and of the distance. *x bound*: each error over its own
  frame's bound, root mean square; 1.00 is the limit.
- *NEES*: mean normalised error squared of position and rotation; 6 is honest, more is overconfident, less too cautious.
- *wrong*: poses on the other side of the planar ambiguity, or with a ring dot taken for its neighbour (more than 20
  degrees off); they are left out of the columns before.
- With {0} frames a row's *x bound* is uncertain by about {1:.0f} % and its NEES by {2:.1f}.

)",
      trials, 100 / std::sqrt(2.0 * trials), std::sqrt(12.0 / trials));
}

}  // namespace

std::string three_digits(double value) {
  const double size = std::abs(value);
  return fmt::format("{:.{}f}", value, size >= 99.95 ? 0 : size >= 9.995 ? 1 : size >= 0.9995 ? 2 : 3);
}

std::string accuracy_page(const std::vector<Sweep>& sweeps, int trials) {
  std::string page = "# Accuracy\n\n" + headline(sweeps) + conditions(trials);
  for (const Sweep& sweep : sweeps) {
    page += fmt::format("## {}\n\n", static_cast<char>(std::toupper(sweep.heading.front())) + sweep.heading.substr(1));
    if (!sweep.note.empty()) page += sweep.note + "\n\n";
    if (!sweep.name.empty())
      page +=
          fmt::format("![Position error over {}: bound, full, ellipse](accuracy-{}.svg)\n\n", sweep.varied, sweep.name);
    page += table(sweep) + "\n";
  }
  page.pop_back();
  return page;
}

}  // namespace ninedot::bench
