// `ninedot calibrate rolling-shutter`: the time from row to row, from a recording of a camera that is moved.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include "base/startup_error.h"
#include "calibrate/row_time_fit.h"
#include "drivers/posix/output_file.h"
#include "programs/assembly/input_files.h"
#include "programs/commands/calibrate_commands.h"
#include "programs/commands/output_check.h"
#include "programs/commands/recording_frames.h"

namespace ninedot {
namespace {

// The recording is looked at again with what the look before found, until that changes nothing.
constexpr int kPasses = 5;
constexpr double kSettled = 0.2;  // of its sigma
// The first look takes all rows for one instant. What that leaves of the outlines makes each sighting up to eight times
// as uncertain as it is; where nobody looks again it is judged like any other.
constexpr double kUsefulAtFirst = 5 * kUsefulRowTime;

struct ShutterArguments {
  std::string recording, config, camera, out;
};

/// \param row_time_s  that the outlines are fitted with \param period_s  out: between two pictures, the
/// median
std::vector<MovingSighting> collect(const ShutterArguments& arguments, Config config, const RecordingView& view,
                                    double row_time_s, double& period_s, bool& is_interrupted) {
  config.camera.row_time_us = 1e6 * row_time_s;
  std::vector<MovingSighting> sightings;
  std::vector<double> steps_s;
  MonoTime last{};
  const SeenFrames looked = look_at_frames(
      arguments.recording, config, view, true, [&](const Frame& frame, const Fix& fix, const LandmarkObservation*) {
        if (last != MonoTime{}) steps_s.push_back(std::chrono::duration<double>(frame.exposed_at() - last).count());
        last = frame.exposed_at();
        for (const LandmarkFix& landmark : fix.landmarks)
          if (landmark.verdict == Reason::kNone || landmark.verdict == Reason::kAmbiguous ||
              landmark.verdict == Reason::kUncertain)
            sightings.push_back({landmark.id, frame.exposed_at(), landmark.sighting.T_camera_landmark,
                                 landmark.sighting.dots, landmark.row_motion.sheet});
      });
  // Sheared outlines are read short, so that a look without a row time alone gives too little of it.
  if (looked.is_interrupted && !(row_time_s > 0))
    throw StartupError(ExitStatus::kWorkFailed, "interrupted during the first look: nothing was written");
  tell_interruption(looked);
  is_interrupted = looked.is_interrupted;
  if (sightings.empty())
    throw StartupError(ExitStatus::kWorkFailed, fmt::format("{}: no picture shows the landmark", arguments.recording));
  if (steps_s.empty())
    throw StartupError(ExitStatus::kWorkFailed, fmt::format("{}: one picture shows no motion", arguments.recording));
  std::ranges::nth_element(steps_s, steps_s.begin() + static_cast<std::ptrdiff_t>(steps_s.size() / 2));
  period_s = steps_s[steps_s.size() / 2];
  return sightings;
}

std::string text_of(const RowTimeFit& fit) {
  const double row_time_us = 1e6 * fit.row_time_s, sigma_us = 1e6 * fit.sigma_s;
  const bool is_global = std::abs(fit.row_time_s) < 3 * fit.sigma_s;
  return fmt::format(
      "# Made by `ninedot calibrate rolling-shutter` from {} sightings, the fastest of {:.0f} px/s.\n"
      "# {:.3f} us, 1-sigma {:.3f} us{}\n"
      "[camera]\nrow_time_us = {:.3f}\n",
      fit.frames, fit.fastest_px_s, row_time_us, sigma_us, is_global ? ": no different from 0, a global shutter" : "",
      is_global ? 0.0 : row_time_us);
}

void run_rolling_shutter(const ShutterArguments& arguments) {
  const Config config = arguments.config.empty() ? Config{} : read_config(arguments.config);
  const RecordingView view = view_of_recording(arguments.recording, arguments.camera, config);
  std::vector<std::string> inputs = files_of(config, {arguments.recording}, arguments.camera);
  inputs.insert(inputs.end(), {arguments.recording, arguments.config});
  check_outputs({{"--out", arguments.out}}, inputs);
  OutputFile out(arguments.out);  // before the work, so that a folder that is not there is told at once
  RowTimeFit fit;
  for (int pass = 0; pass < kPasses; ++pass) {
    const double before_s = std::max(0.0, fit.row_time_s);
    double period_s = 0;
    bool is_interrupted = false;
    const std::vector<MovingSighting> sightings = collect(arguments, config, view, before_s, period_s, is_interrupted);
    if (!(period_s > 0))
      throw StartupError(
          ExitStatus::kWorkFailed,
          fmt::format("{}: its pictures have no times; record anew with `ninedot record`", arguments.recording));
    const double longest_s = period_s / view.camera.height_px;
    const bool is_last = pass > 0 || is_interrupted;
    fit = fit_row_time(sightings, view.camera, view.landmark, longest_s, is_last ? kUsefulRowTime : kUsefulAtFirst);
    const bool is_settled =
        std::abs(fit.row_time_s - before_s) < kSettled * fit.sigma_s && fit.sigma_s < kUsefulRowTime * longest_s;
    if (is_interrupted || is_settled) break;
  }
  const std::string text = text_of(fit);
  out.write(text);
  out.finish();
  if (!arguments.out.empty() && arguments.out != "-") fmt::print(stderr, "{}", text);
}

}  // namespace

void add_calibrate_rolling_shutter_command(CLI::App& group) {
  CLI::App* command =
      group.add_subcommand("rolling-shutter", "The time from row to row, from a recording of a moving camera");
  const auto arguments = std::make_shared<ShutterArguments>();
  command->add_option("RECORDING", arguments->recording, "folder with frames/ and frames.csv")->required();
  command->add_option("--config", arguments->config, "landmarks; default: the default landmark");
  command->add_option("--camera", arguments->camera, "calibration; default: the recording's, then the configuration's");
  command->add_option("--out", arguments->out, "file for the line of the configuration; default: standard output");
  command->callback([arguments] { run_rolling_shutter(*arguments); });
}

}  // namespace ninedot
