// Writes docs/accuracy.md and its plots: every solver over distance, tilt, noise, occlusion, off-axis angle, tone curve
// and light, beside the Cramer-Rao bound.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <numbers>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "tests/bench/accuracy_report.h"

namespace ninedot::bench {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

Sweep sweep_over(std::string name, std::string heading, std::string varied, std::string note,
                 const std::vector<double>& values, const std::function<void(Condition&, double)>& set) {
  Sweep sweep{std::move(name), std::move(heading), std::move(varied), std::move(note), {}, {}};
  for (const double value : values) {
    Condition condition;
    condition.label = fmt::format("{:g}", value), condition.plot_x = value;
    set(condition, value);
    sweep.conditions.push_back(condition);
  }
  return sweep;
}

Sweep tone_and_light() {
  Sweep sweep{"", "tone curve and light", "picture", "", {}, {}};
  const auto add = [&](const char* label, const std::function<void(Condition&)>& set) {
    Condition condition;
    condition.label = label;
    set(condition);
    sweep.conditions.push_back(condition);
  };
  add("sRGB curve", [](Condition&) {});
  add("linear", [](Condition& c) { c.tone = test::ToneCurve::kLinear; });
  add("sRGB curve, 4 m", [](Condition& c) { c.distance_m = 4; });
  add("linear, 4 m", [](Condition& c) { c.distance_m = 4, c.tone = test::ToneCurve::kLinear; });
  add("light falls by half across the sheet", [](Condition& c) { c.light_gradient_per_m = 3.2; });
  add("hard shadow across the sheet", [](Condition& c) { c.hard_shadow = true; });
  add("haze, 50 % veil", [](Condition& c) { c.veil = 0.5; });
  return sweep;
}

std::vector<Sweep> all_sweeps() {
  const std::string hidden_note =
      "A textured board comes from any side and hides this part of the sheet's area; the bound knows only what is "
      "left.";
  std::vector<Sweep> sweeps = {
      sweep_over("distance", "distances from 0.3 m to 7 m", "distance, m", "", {0.3, 0.5, 1, 2, 3, 4.4, 5.5, 7},
                 [](Condition& c, double m) { c.distance_m = m; }),
      sweep_over("tilt", "tilt", "tilt, degrees",
                 "Seen from straight ahead the tilt itself is what the picture tells least about, and with it the "
                 "place of the "
                 "camera: the bound says so. The wrong poses are misnumbered ones: a black-and-white landmark is "
                 "numbered by the "
                 "camera's roll, seen from 70 degrees P1 and its neighbours are only some 15 degrees of roll apart, "
                 "and the camera of "
                 "this page rolls by up to 15.",
                 {0, 5, 15, 30, 45, 60, 70, 75}, [](Condition& c, double deg) { c.tilt_rad = deg * kDegree; }),
      sweep_over("noise", "noise", "noise at grey level 128, grey levels", "", {0.5, 1, 2, 4, 8, 12},
                 [](Condition& c, double lsb) { c.noise_at_grey128_lsb = lsb; }),
      sweep_over("occlusion", "occlusion", "hidden, % of the sheet", hidden_note, {0, 10, 20, 30, 40, 50},
                 [](Condition& c, double percent) { c.hidden_fraction = percent / 100; }),
      sweep_over("off-axis", "off-axis angle", "off-axis angle, degrees", "", {0, 5, 10, 15, 19},
                 [](Condition& c, double deg) { c.off_axis_rad = deg * kDegree; }),
      sweep_over("distorted", "off-axis angle through a distorting lens", "off-axis angle through the lens, degrees",
                 "`plumb_bob` with k1 = -0.12, k2 = 0.05, p1 = 0.0008, p2 = -0.0005, known to the solvers.",
                 {0, 5, 10, 15, 19},
                 [](Condition& c, double deg) { c.off_axis_rad = deg * kDegree, c.distorted = true; }),
      tone_and_light()};
  return sweeps;
}

// Rows in any order on all threads; each row's seed is its own, so that the page does not depend on the order.
void run(std::vector<Sweep>& sweeps, int trials, unsigned threads) {
  struct Row {
    const Condition* condition;
    Outcome* outcome;
  };
  std::vector<Row> rows;
  for (Sweep& sweep : sweeps) {
    sweep.outcomes.resize(sweep.conditions.size());
    for (std::size_t i = 0; i < sweep.conditions.size(); ++i)
      rows.push_back({&sweep.conditions[i], &sweep.outcomes[i]});
  }
  const bool terminal = isatty(STDERR_FILENO) != 0;
  std::atomic<std::size_t> next{0}, done{0};
  std::vector<std::jthread> workers;
  for (unsigned t = 0; t < threads; ++t)
    workers.emplace_back([&] {
      for (std::size_t row = next++; row < rows.size(); row = next++) {
        *rows[row].outcome = run_trials(*rows[row].condition, trials, 1000 + row);
        if (const std::size_t finished = ++done; terminal) fmt::print(stderr, "\r{} of {} rows", finished, rows.size());
      }
    });
  workers.clear();
  if (terminal) fmt::print(stderr, "\n");
}

bool write_file(const std::filesystem::path& path, const std::string& text) {
  std::ofstream file(path, std::ios::binary | std::ios::trunc);
  file << text;
  file.close();
  if (!file)
    fmt::print(stderr, "accuracy: cannot write {}: choose a place that can be written to with --out\n", path.string());
  return static_cast<bool>(file);
}

int main_with(const std::vector<std::string_view>& arguments) {
  std::filesystem::path out = "docs/accuracy.md";
  int trials = 60;
  int threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  for (std::size_t i = 0; i < arguments.size(); i += 2) {
    const std::string value(i + 1 < arguments.size() ? arguments[i + 1] : "");
    if (arguments[i] == "--out" && !value.empty()) {
      out = value;
    } else if (arguments[i] == "--trials" && std::atoi(value.c_str()) > 0) {
      trials = std::atoi(value.c_str());
    } else if (arguments[i] == "--threads" && std::atoi(value.c_str()) > 0) {
      threads = std::atoi(value.c_str());
    } else {
      fmt::print(stderr, "usage: accuracy [--out docs/accuracy.md] [--trials N] [--threads N]\n");
      return 2;
    }
  }
  std::vector<Sweep> sweeps = all_sweeps();
  run(sweeps, trials, static_cast<unsigned>(threads));
  for (const Sweep& sweep : sweeps)
    if (!sweep.name.empty() &&
        !write_file(out.parent_path() / fmt::format("accuracy-{}.svg", sweep.name), accuracy_plot(sweep)))
      return 1;
  return write_file(out, accuracy_page(sweeps, trials)) ? 0 : 1;
}

}  // namespace
}  // namespace ninedot::bench

int main(int argc, char** argv) { return ninedot::bench::main_with({argv + 1, argv + argc}); }
