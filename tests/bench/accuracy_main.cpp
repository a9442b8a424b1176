// Writes docs/accuracy.md and its plots: every solver over distance, tilt, noise, occlusion, off-axis angle, tone curve
// and light, and walks through rooms of landmarks, beside the Cramer-Rao bound.
#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <numbers>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "tests/bench/accuracy_report.h"

namespace ninedot::bench {
namespace {

constexpr double kDegree = std::numbers::pi / 180;
constexpr std::uint64_t kRoomsSeed = 5000;

template <typename AnySweep>
AnySweep sweep_over(const char* name, const char* heading, const char* varied, const char* note,
                    const std::vector<double>& values,
                    const std::function<void(typename AnySweep::Row&, double)>& set) {
  AnySweep sweep{name, heading, varied, note, {}, {}};
  for (const double value : values) {
    typename AnySweep::Row condition;
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
  const char* const hidden_note =
      "A textured board comes from any side and hides this part of the sheet's area; the bound knows only what is "
      "left.";
  std::vector<Sweep> sweeps = {
      sweep_over<Sweep>("distance", "distances from 0.3 m to 7 m", "distance, m", "", {0.3, 0.5, 1, 2, 3, 4.4, 5.5, 7},
                        [](Condition& c, double m) { c.distance_m = m; }),
      sweep_over<Sweep>(
          "tilt", "tilt", "tilt, degrees",
          "Seen from straight ahead the tilt itself is what the picture tells least about, and with it the "
          "place of the "
          "camera: the bound says so. The wrong poses are misnumbered ones: a black-and-white landmark is "
          "numbered by the "
          "camera's roll, seen from 70 degrees P1 and its neighbours are only some 15 degrees of roll apart, "
          "and the camera of "
          "this page rolls by up to 15.",
          {0, 5, 15, 30, 45, 60, 70, 75}, [](Condition& c, double deg) { c.tilt_rad = deg * kDegree; }),
      sweep_over<Sweep>("noise", "noise", "noise at grey level 128, grey levels", "", {0.5, 1, 2, 4, 8, 12},
                        [](Condition& c, double lsb) { c.noise_at_grey128_lsb = lsb; }),
      sweep_over<Sweep>("occlusion", "occlusion", "hidden, % of the sheet", hidden_note, {0, 10, 20, 30, 40, 50},
                        [](Condition& c, double percent) { c.hidden_fraction = percent / 100; }),
      sweep_over<Sweep>("off-axis", "off-axis angle", "off-axis angle, degrees", "", {0, 5, 10, 15, 19},
                        [](Condition& c, double deg) { c.off_axis_rad = deg * kDegree; }),
      sweep_over<Sweep>(
          "distorted", "off-axis angle through a distorting lens", "off-axis angle through the lens, degrees",
          "`plumb_bob` with k1 = -0.12, k2 = 0.05, p1 = 0.0008, p2 = -0.0005, known to the solvers.",
          {0, 5, 10, 15, 19}, [](Condition& c, double deg) { c.off_axis_rad = deg * kDegree, c.distorted = true; }),
      tone_and_light()};
  return sweeps;
}

std::vector<RoomSweep> all_room_sweeps() {
  const auto walk = [](RoomCondition& c, double m_s) {
    c.speed_m_s = m_s, c.exposure_s = m_s > 1 ? 0.006 : m_s == 1 ? 0.005 : 0.004;
    c.label = m_s == 0 ? "0" : fmt::format("{:g}, {:g} ms", m_s, 1000 * c.exposure_s);
  };
  return {sweep_over<RoomSweep>("rooms-distance", "Distance", "distance of the wall, m", "", {1, 1.5, 2, 3, 4, 5},
                                [](RoomCondition& c, double m) { c.distance_m = m; }),
          sweep_over<RoomSweep>("rooms-noise", "Noise", "noise at grey level 128, grey levels", "", {1, 2, 4, 8},
                                [](RoomCondition& c, double lsb) { c.noise_at_grey128_lsb = lsb; }),
          sweep_over<RoomSweep>("rooms-speed", "Speed", "speed, m/s, and exposure",
                                "Standing, the head does not turn either, and all frames of a walk are of one place.",
                                {0, 0.5, 1, 1.6}, walk),
          sweep_over<RoomSweep>("rooms-shutter", "Rolling shutter", "readout of all rows, ms",
                                "0 is a global shutter. The configuration knows of it each time (`row_time_us`).",
                                {0, 8, 16, 33}, [](RoomCondition& c, double ms) { c.readout_s = ms / 1000; }),
          sweep_over<RoomSweep>("", "Colour of the light", "light, K",
                                "For a camera that stays balanced for 5000 K: warm (3000 K), neutral, cool (8000 K).",
                                {3000, 5000, 8000}, [](RoomCondition& c, double kelvin) { c.light_kelvin = kelvin; }),
          sweep_over<RoomSweep>("", "A shutter that nobody told of", "readout of all rows, ms",
                                "The configuration has no `row_time_us`: pictures have to show it. Until they have, "
                                "places are as uncertain as that "
                                "makes them.",
                                {0, 8, 16, 33},
                                [](RoomCondition& c, double ms) { c.readout_s = ms / 1000, c.is_told = false; })};
}

using Rows = std::vector<std::function<void()>>;

// Seeds are by place in the page, so that it does not depend on the order in which rows are made.
template <typename AnySweep, typename MakeRow>
void add_rows(std::vector<AnySweep>& sweeps, std::uint64_t seed, MakeRow make_row, Rows& rows) {
  for (AnySweep& sweep : sweeps) {
    sweep.outcomes.resize(sweep.conditions.size());
    for (std::size_t i = 0; i < sweep.conditions.size(); ++i)
      rows.emplace_back(
          [&sweep, i, make_row, own = seed++] { sweep.outcomes[i] = make_row(sweep.conditions[i], own); });
  }
}

// In any order on all threads.
void run(const Rows& rows, unsigned threads) {
  const bool terminal = isatty(STDERR_FILENO) != 0;
  std::atomic<std::size_t> next{0}, done{0};
  std::vector<std::jthread> workers;
  for (unsigned t = 0; t < threads; ++t)
    workers.emplace_back([&] {
      for (std::size_t row = next++; row < rows.size(); row = next++) {
        rows[row]();
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

template <typename AnySweep>
bool write_plots(const std::filesystem::path& folder, const std::vector<AnySweep>& sweeps) {
  return std::ranges::all_of(sweeps, [&](const AnySweep& sweep) {
    return sweep.name.empty() || write_file(folder / fmt::format("accuracy-{}.svg", sweep.name), accuracy_plot(sweep));
  });
}

/// The page's two parts as they are; empty where there is none yet.
struct Page {
  std::string singles, rooms;

  explicit Page(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    const std::string heading = std::string("\n") + kRoomsHeading;
    const std::size_t rooms_at = std::min(text.find(heading), text.size());
    singles = text.substr(0, rooms_at), rooms = text.substr(std::min(rooms_at + 1, text.size()));
  }
  std::string text() const { return singles + (singles.empty() || rooms.empty() ? "" : "\n") + rooms; }
};

struct Options {
  std::filesystem::path out = "docs/accuracy.md";
  int trials = 60;
  unsigned threads = std::max(1U, std::thread::hardware_concurrency());
  std::string only;  ///< singles, rooms; empty: both
};

int make_page(const Options& options) {
  std::vector<Sweep> sweeps;
  std::vector<RoomSweep> room_sweeps;
  if (options.only != "rooms") sweeps = all_sweeps();
  if (options.only != "singles") room_sweeps = all_room_sweeps();
  Rows rows;
  add_rows(
      sweeps, 1000, [&](const Condition& c, std::uint64_t seed) { return run_trials(c, options.trials, seed); }, rows);
  // The same rooms in all rows: what differs between them is what is varied.
  add_rows(
      room_sweeps, 0, [](const RoomCondition& c, std::uint64_t) { return run_walks(c, kRoomsSeed); }, rows);
  run(rows, options.threads);
  Page page(options.out);
  if (!sweeps.empty()) page.singles = accuracy_page(sweeps, options.trials);
  if (!room_sweeps.empty()) page.rooms = rooms_part(room_sweeps);
  const std::filesystem::path folder = options.out.parent_path();
  return write_plots(folder, sweeps) && write_plots(folder, room_sweeps) && write_file(options.out, page.text()) ? 0
                                                                                                                 : 1;
}

int main_with(const std::vector<std::string_view>& arguments) {
  Options options;
  for (std::size_t i = 0; i < arguments.size(); i += 2) {
    const std::string value(i + 1 < arguments.size() ? arguments[i + 1] : "");
    if (arguments[i] == "--out" && !value.empty()) {
      options.out = value;
    } else if (arguments[i] == "--only" && (value == "singles" || value == "rooms")) {
      options.only = value;
    } else if (arguments[i] == "--trials" && std::atoi(value.c_str()) > 0) {
      options.trials = std::atoi(value.c_str());
    } else if (arguments[i] == "--threads" && std::atoi(value.c_str()) > 0) {
      options.threads = static_cast<unsigned>(std::atoi(value.c_str()));
    } else {
      fmt::print(
          stderr,
          "usage: accuracy [--out docs/accuracy.md] [--only singles|rooms] [--trials N] [--threads N]\n"
          "--only makes one part of the page and leaves the other as it is; --trials: frames per row of singles\n");
      return 2;
    }
  }
  return make_page(options);
}

}  // namespace
}  // namespace ninedot::bench

int main(int argc, char** argv) { return ninedot::bench::main_with({argv + 1, argv + argc}); }
