// `ninedot calibrate pan-tilt`: how a head is made and how it tells its angles, from recordings or from the head
// itself.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <chrono>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "base/startup_error.h"
#include "calibrate_head/head_sufficiency.h"
#include "drivers/posix/output_file.h"
#include "drivers/posix/signals.h"
#include "programs/assembly/input_files.h"
#include "programs/assembly/motion_options.h"
#include "programs/commands/calibrate_commands.h"
#include "programs/commands/collect_head_frames.h"
#include "programs/commands/head_file_text.h"
#include "programs/commands/head_news.h"
#include "programs/commands/live_head.h"
#include "programs/commands/output_check.h"
#include "programs/commands/progress.h"
#include "programs/commands/recording_frames.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

struct PanTiltArguments {
  std::vector<std::string> recordings;
  std::string config, camera, out;
  std::string stops;
  std::string progress;  // "json", or nothing
  bool tap = false;
};

[[noreturn]] void refuse_usage(const std::string& what) { throw StartupError(ExitStatus::kWrongUsage, what); }

/// "7x5"
std::pair<int, int> read_stops(const std::string& text) {
  constexpr int kLeast = 3, kMost = 25;
  int columns = 0, rows = 0;
  const char* const end = text.data() + text.size();
  const auto [x, no_columns] = std::from_chars(text.data(), end, columns);
  const auto [last, no_rows] = std::from_chars(std::min(x + 1, end), end, rows);
  if (no_columns != std::errc() || no_rows != std::errc() || *x != 'x' || last != end ||
      std::min(columns, rows) < kLeast || std::max(columns, rows) > kMost)
    refuse_usage(fmt::format("--stops {}: write COLUMNSxROWS, {} to {} of each, as 7x5", text, kLeast, kMost));
  return {columns, rows};
}

/// Throws StartupError(kWorkFailed) with all of them in one line.
void refuse(const std::vector<std::string>& lacks) {
  if (!lacks.empty()) throw StartupError(ExitStatus::kWorkFailed, fmt::format("{}", fmt::join(lacks, "; ")));
}

HeadCalibration calibrate(const std::vector<HeadFrame>& frames, const LandmarkGeometry& landmark, const Config& config,
                          const TerminationSignals& signals, HeadNews* news) {
  const FoundStops found = find_stops(frames);
  refuse(what_stops_lack(found));
  Progress progress;
  bool is_stopped = false;
  const auto head = calibrate_head(found.stops, landmark, body_geometry(config.body), [&] {
    const std::string words = fmt::format("{} stops: working out the head", found.stops.size());
    progress.show(words);
    if (news != nullptr) news->working(words);
    is_stopped = is_stopped || signals.wait(0ns) != 0 || (news != nullptr && news->is_broken());
    return !is_stopped;
  });
  progress.clear();
  if (!head && is_stopped) refuse({"stopped: nothing was written"});
  if (!head) refuse({"no head explains the stops: were robot or landmarks moved in between, or does the head slip?"});
  refuse(what_head_lacks(*head));
  return *head;
}

void check_arguments(const PanTiltArguments& arguments) {
  const bool is_live = arguments.recordings.empty();
  if (!is_live && !arguments.stops.empty())
    refuse_usage("--stops is for a head that is moved now: leave it out, or the recordings");
  if (!is_live && arguments.tap)
    refuse_usage("--tap moves a running service's head, and recordings have moved: leave out the one or the other");
  if (is_live && !arguments.camera.empty())
    refuse_usage("--camera belongs to recordings: a camera that is opened has camera.calibration");
  if (!arguments.progress.empty() && arguments.out == "-")
    refuse_usage("--progress and --out - would both write to standard output: name a file");
  check_named({"--out", arguments.out});
  refuse_repeated(arguments.recordings);  // its stops would count twice, and its landmark for two
  std::vector<std::string> inputs = arguments.recordings;
  inputs.insert(inputs.end(), {arguments.config, arguments.camera});
  check_outputs({{"--out", arguments.out}}, inputs);
}

void calibrate_pan_tilt(const PanTiltArguments& arguments, HeadNews* news) {
  const auto [columns, rows] = read_stops(arguments.stops.empty() ? "7x5" : arguments.stops);
  check_arguments(arguments);
  const Config config = read_config(arguments.config);
  check_outputs({{"--out", arguments.out}}, files_of(config, arguments.recordings, arguments.camera));
  const TerminationSignals signals;  // before the first thread
  OutputFile out(arguments.out);     // before the work, so that a folder that is not there is told at once
  LandmarkGeometry landmark;
  std::vector<HeadFrame> frames;
  std::string source = "a tour of the head";
  if (arguments.recordings.empty()) {
    LiveTour tour = tour_live(config, {columns, rows, arguments.tap ? arguments.config : "", news}, signals, landmark);
    if (tour.is_interrupted)
      fmt::print(stderr, "ninedot: interrupted, the head stands: what follows is of the stops until then\n");
    frames = std::move(tour.frames);
  } else {
    frames = collect_head_frames(arguments.recordings, arguments.camera, config, landmark);
    source = fmt::format("{}", fmt::join(arguments.recordings, ", "));
  }
  const HeadCalibration head = calibrate(frames, landmark, config, signals, news);
  out.write(head_file_text(head, config, source));
  out.finish();
  const std::vector<std::string> lines = head_summary(head);
  for (const std::string& line : lines) fmt::print(stderr, "{}\n", line);
  if (news != nullptr) news->done(head, lines, arguments.out);
}

}  // namespace

void add_calibrate_pan_tilt_command(CLI::App& group) {
  CLI::App* command = group.add_subcommand("pan-tilt",
                                           "Axes, lengths and tables of a pan/tilt head before landmarks that hang "
                                           "still: moving it now, or from recordings");
  const auto arguments = std::make_shared<PanTiltArguments>();
  command->add_option(
      "RECORDING", arguments->recordings,
      "folders with frames/ and frames.csv, which has the head's angles; none: the configured head is moved now, "
      "within min_deg to max_deg");
  command->add_option("--config", arguments->config, "landmarks, and what is known of the head: [body], [pan_tilt]")
      ->required();
  command->add_option("--camera", arguments->camera,
                      "calibration of the camera; default: the recording's, then the configuration's");
  command->add_option(
      "--stops", arguments->stops,
      "without a recording: COLUMNSxROWS of stops, 3 to 25 of each, and between the rows again; default: 7x5");
  command->add_flag("--tap", arguments->tap,
                    "move the head of the service that runs with --config, which goes on meanwhile; its [tap] must be "
                    "on, and modbus.allow_writes");
  command
      ->add_option("--progress", arguments->progress,
                   "json: a line on standard output for each step, for another program")
      ->check(CLI::IsMember({"json"}));
  command->add_option("--out", arguments->out, "file for the sections of the configuration; -: standard output")
      ->required();
  command->callback([arguments] {
    with_news<HeadNews>(arguments->progress, [&](HeadNews* news) { calibrate_pan_tilt(*arguments, news); });
  });
}

}  // namespace ninedot
