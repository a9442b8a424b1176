// `ninedot simulate`: a scenario in virtual time, as rows of what was true and what the head was told.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <ctime>
#include <limits>
#include <memory>
#include <string>
#include <system_error>
#include <vector>

#include "base/startup_error.h"
#include "base/units.h"
#include "drivers/posix/output_file.h"
#include "programs/assembly/input_files.h"
#include "programs/assembly/open_source.h"
#include "programs/assembly/simulation_options.h"
#include "programs/commands/commands.h"
#include "programs/commands/named_option.h"
#include "programs/commands/output_check.h"
#include "programs/commands/progress.h"
#include "programs/simulation/virtual_run.h"

namespace ninedot {
namespace {

struct SimulateArguments {
  std::string scenario, out = "-", controller = "servoing";
  std::uint64_t seed = 1;
};

/// CLI11's own range is one of floating-point numbers, and tells its end with 309 digits.
CLI::Validator is_seed() {
  return CLI::Validator(
      [](const std::string& word) {
        std::uint64_t seed = 0;
        const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), seed);
        return error == std::errc() && end == word.data() + word.size()
                   ? std::string()
                   : fmt::format("'{}' is no seed: give a whole number, 0 to {}", word,
                                 std::numeric_limits<std::uint64_t>::max());
      },
      "");
}

/// For the line at the end.
struct Summary {
  int frames = 0, visible = 0, valid = 0;
  double sum_square_deg2 = 0, largest_deg = 0;
  std::clock_t began_at = std::clock();

  void add(const SimulationRow& row) {
    ++frames;
    visible += row.truth.visible ? 1 : 0;
    valid += row.valid ? 1 : 0;
    const double error_deg = row.truth.centre_error_rad * kDegPerRad;
    sum_square_deg2 += error_deg * error_deg;
    largest_deg = std::max(largest_deg, error_deg);
  }
  void print(double simulated_s) const {
    const double took_s = static_cast<double>(std::clock() - began_at) / CLOCKS_PER_SEC;
    fmt::print(stderr,
               "{} frames, landmark in view in {}, pose valid in {}; off the centre by {:.2f} deg (rms), {:.2f} deg at "
               "most; {:.6g} s simulated in {:.2f} s of one core, {:.1f} times as fast as in reality\n",
               frames, visible, valid, frames > 0 ? std::sqrt(sum_square_deg2 / frames) : 0, largest_deg, simulated_s,
               took_s, simulated_s / std::max(took_s, 1e-3));
  }
};

Config read_scenario(const std::string& path) {
  ConfigProblems problems;
  Config config = read_config(path, problems);
  refuse_first(problems, path);
  if (config.simulation.robot.empty())
    throw StartupError(ExitStatus::kWrongUsage,
                       problem_text(path, {problems.line_of("simulation"),
                                           "a scenario needs [[simulation.robot]]: where the robot is, and when",
                                           {}}));
  return config;
}

void run_simulate(const SimulateArguments& arguments) {
  const Config config = read_scenario(arguments.scenario);
  std::vector<std::string> inputs = files_of(config);
  inputs.push_back(arguments.scenario);
  check_outputs({{"--out", arguments.out}}, inputs);
  const CameraModel camera = simulated_camera_model(config.camera);
  VirtualRunOptions options;
  options.seed = arguments.seed;
  if (arguments.controller == "pid") options.controller = SimulatedController::kPid;
  VirtualRun run(config, camera, options);
  OutputFile file(arguments.out);
  file.write(simulation_csv_header());
  Progress progress;
  Summary summary;
  while (const std::optional<SimulationRow> row = run.next()) {
    file.write(simulation_csv_row(*row));
    summary.add(*row);
    if (progress.is_due())
      progress.show(fmt::format("{:.1f} of {:.1f} s", row->truth.t_s, config.simulation.duration_s));
  }
  progress.clear();
  file.finish();
  summary.print(config.simulation.duration_s);
}

}  // namespace

void add_simulate_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("simulate", "Drive a simulated robot through a scenario, faster than in reality");
  const auto arguments = std::make_shared<SimulateArguments>();
  command->add_option("scenario", arguments->scenario, "a configuration with [simulation]: see docs/simulation.md")
      ->required();
  command->add_option("--out", arguments->out, "CSV file, a row for each frame; default: - (standard output)")
      ->check(is_named());
  command->add_option("--seed", arguments->seed, "of the camera's noise: a whole number, not negative; default: 1")
      ->check(is_seed());
  command->add_option("--controller", arguments->controller, "servoing (default), or pid: a plain one on pixels")
      ->check(CLI::IsMember({"servoing", "pid"}));
  command->callback([arguments] { run_simulate(*arguments); });
}

}  // namespace ninedot
