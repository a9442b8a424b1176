// `ninedot calibrate camera`: a lens from views of a landmark, or of a printed grid of dots: a camera's, while somebody
// moves the sheet, or those of recordings.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "base/startup_error.h"
#include "config/config.h"
#include "drivers/camera/camera_device.h"
#include "drivers/posix/output_file.h"
#include "drivers/posix/signals.h"
#include "programs/assembly/input_files.h"
#include "programs/assembly/open_source.h"
#include "programs/commands/calibrate_commands.h"
#include "programs/commands/calibration_news.h"
#include "programs/commands/calibration_output.h"
#include "programs/commands/calibration_target.h"
#include "programs/commands/lens_from_views.h"
#include "programs/commands/output_check.h"
#include "programs/commands/tapped_source.h"

namespace ninedot {
namespace {

struct CalibrateCameraArguments {
  std::vector<std::string> recordings;
  SheetArguments sheet;
  std::string out, picture, keep, lens;
  std::string progress;  // "json", or nothing
  bool tap = false;
  bool is_live() const { return recordings.empty(); }
};

[[noreturn]] void refuse(const std::string& what) { throw StartupError(ExitStatus::kWrongUsage, what); }

void check_arguments(const CalibrateCameraArguments& arguments) {
  if (arguments.is_live() && arguments.sheet.config.empty())
    refuse("give recordings of a sheet, or --config FILE, whose camera will be watched while you move the sheet");
  if (arguments.tap && !arguments.is_live())
    refuse("--tap watches a running service, and recordings are not watched: leave out the one or the other");
  if (!arguments.progress.empty() && (arguments.out == "-" || arguments.picture == "-"))
    refuse(fmt::format("--progress and {} - would both write to standard output: name a file",
                       arguments.out == "-" ? "--out" : "--picture"));
  if (!arguments.is_live() && !arguments.keep.empty())
    refuse("--keep is for a camera's views; those of recordings are there already: leave it out");
  if (!arguments.is_live() && !arguments.sheet.config.empty() && !arguments.sheet.grid.empty())
    refuse("recordings of a grid need no --config: leave it out, or leave out the recordings to watch its camera");
}

/// A camera has one user, and here that is the service most often.
OpenedSource open_camera(const Config& config) {
  const CalibrationRecord calibration_to_be;  // for one focus of the lens, as any
  try {
    return open_source(config, FrameDemand::kEveryFrame, &calibration_to_be);
  } catch (const CameraRefused& refusal) {
    if (refusal.os_errno != EBUSY) throw;
    throw StartupError(refusal.status,
                       fmt::format("{}; if the service has it: --tap watches through it, or `systemctl stop ninedotd`",
                                   refusal.what()));
  }
}

/// A folder beside the calibration that is not there yet: the views are ten minutes of somebody's work.
std::string folder_for_views(const CalibrateCameraArguments& arguments) {
  if (!arguments.keep.empty() || arguments.out == "-") return arguments.keep;
  const std::string first = std::filesystem::path(arguments.out).replace_extension().string() + "-views";
  std::string folder = first;
  for (int number = 2; std::filesystem::exists(folder); ++number) folder = fmt::format("{}-{}", first, number);
  return folder;
}

/// The files of the outcome, opened before the work, so that a folder that is not there is told at once.
class CalibrationFiles {
 public:
  explicit CalibrationFiles(const CalibrateCameraArguments& arguments)
      : arguments_(arguments), camera_file_(arguments.out) {
    if (const std::string picture = picture_beside(arguments.out, arguments.picture); !picture.empty())
      picture_file_.emplace(picture);
  }

  void write(const LensCalibration& result, std::span<const PlaneDisc> discs) {
    if (picture_file_) picture_file_->write(picture_of(result, discs));
    camera_file_.write(
        camera_file_of(result, camera_name_of(arguments_.out), arguments_.lens, !arguments_.sheet.model.empty()));
    finish_together({picture_file_ ? &*picture_file_ : nullptr, &camera_file_});
  }

 private:
  const CalibrateCameraArguments& arguments_;
  OutputFile camera_file_;
  std::optional<OutputFile> picture_file_;
};

LensCalibration watch_camera(LensFromViews& calibration, const CalibrateCameraArguments& arguments,
                             const Config& config) {
  const std::string keep = folder_for_views(arguments);
  const OpenedSource source = arguments.tap ? open_tapped_source(arguments.sheet.config, config) : open_camera(config);
  if (keep.empty()) fmt::print(stderr, "no views are kept: --keep FOLDER would\n");
  LensCalibration result = calibration.of_camera(source, keep);
  if (!keep.empty()) fmt::print(stderr, "the views are kept in {}\n", keep);
  return result;
}

std::vector<std::string> result_lines(const LensCalibration& result, bool is_forced) {
  std::vector<std::string> lines = model_lines(result, is_forced);
  if (result.left_out > 0)
    lines.push_back(fmt::format("{} {} left out: no outline there, or other than the rest has it", result.left_out,
                                result.left_out == 1 ? "view was" : "views were"));
  lines.push_back(summary_of(result));
  return lines;
}

void calibrate_camera(const CalibrateCameraArguments& arguments, CalibrationNews* news) {
  const std::string picture = picture_beside(arguments.out, arguments.picture);
  std::vector<std::string> inputs = arguments.recordings;
  inputs.push_back(arguments.sheet.config);
  check_outputs({{"--out", arguments.out}, {"--picture", picture}}, inputs);
  const TerminationSignals signals;  // before the first thread
  const std::optional<Config> config =
      arguments.sheet.config.empty() ? std::nullopt : std::optional(read_config(arguments.sheet.config));
  CalibrationPictures pictures;
  if (arguments.is_live())
    pictures.size = {config->camera.width_px, config->camera.height_px};
  else
    pictures = check_recordings(arguments.recordings);
  const LensCalibrationOptions lens = lens_options(pictures, arguments.sheet.model);
  LensFromViews calibration(target_of(arguments.sheet, config), lens, signals, news);
  CalibrationFiles files(arguments);
  const LensCalibration result =
      arguments.is_live() ? watch_camera(calibration, arguments, *config)
                          : calibration.of_recordings(pictures, LensFromViews::Interrupted::kUsesWhatThereIs);
  files.write(result, calibration.target().discs);
  const std::vector<std::string> lines = result_lines(result, !arguments.sheet.model.empty());
  for (const std::string& line : lines) fmt::print(stderr, "{}\n", line);
  if (const std::string wish = wish_for_views(result); !wish.empty()) fmt::print(stderr, "{}\n", wish);
  if (news != nullptr) news->done(result, lines, arguments.out, picture);
}

void run_calibrate_camera(const CalibrateCameraArguments& arguments) {
  check_arguments(arguments);
  check_named({"--out", arguments.out});
  with_news<CalibrationNews>(arguments.progress, [&](CalibrationNews* news) { calibrate_camera(arguments, news); });
}

}  // namespace

void add_calibrate_camera_command(CLI::App& group) {
  CLI::App* command = group.add_subcommand(
      "camera",
      "Focal lengths, centre and distortion, from views of a landmark from many sides: the camera's of "
      "--config while you move the sheet, or those of recordings");
  const auto arguments = std::make_shared<CalibrateCameraArguments>();
  command->add_option("RECORDING", arguments->recordings, "folders with frames/, or .y4m files; none: the camera");
  command->add_option("--config", arguments->sheet.config,
                      "whose [camera] is watched where there is no recording, and whose [landmark] says how large the "
                      "sheet is; default: 80 mm");
  add_sheet_options(*command, arguments->sheet);
  command->add_option("--keep", arguments->keep,
                      "a new folder: the camera's views as a recording, to calibrate from again; default: beside "
                      "--out, as camera-views");
  command->add_flag("--tap", arguments->tap,
                    "watch through the service that runs with --config, which goes on meanwhile; its [tap] must be on");
  command
      ->add_option("--progress", arguments->progress,
                   "json: a line of JSON on standard output for each piece of news, for programs that show them")
      ->check(CLI::IsMember({"json"}));
  command->add_option("--lens", arguments->lens, "what to call the lens in the file");
  command
      ->add_option("--out", arguments->out,
                   "file for the calibration, which camera.calibration may name; -: standard output")
      ->required();
  command->add_option("--picture", arguments->picture,
                      "SVG file: coverage, residuals and errors of directions; default: beside --out");
  command->callback([arguments] { run_calibrate_camera(*arguments); });
}

}  // namespace ninedot
