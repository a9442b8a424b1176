// `ninedot replay`: every frame of a recording once through the localiser, and out as CSV or TUM rows. The same input
// gives the same bytes, but for the column process_us.
#include <fmt/format.h>
#include <sys/stat.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/startup_error.h"
#include "config/config.h"
#include "drawing/overlay.h"
#include "drivers/picture/picture_file.h"
#include "drivers/posix/output_file.h"
#include "drivers/recording/recording_source.h"
#include "outputs/wire_output.h"
#include "pipeline/next_report.h"
#include "programs/assembly/input_files.h"
#include "programs/assembly/localiser_options.h"
#include "programs/assembly/make_localiser.h"
#include "programs/assembly/motion_options.h"
#include "programs/assembly/recording_camera.h"
#include "programs/assembly/row_time_text.h"
#include "programs/assembly/zoom_choice.h"
#include "programs/commands/commands.h"
#include "programs/commands/named_option.h"
#include "programs/commands/output_check.h"
#include "programs/commands/progress.h"
#include "programs/commands/recording_frames.h"
#include "programs/commands/world_rows.h"
#include "proto/pose_csv.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

struct ReplayArguments {
  std::string recording, config, camera, out, out_world, out_track, format = "csv", of_frame = "camera", euler,
                                                                    overlay_folder;
  bool realtime = false, keep_going = false;
};

struct ReplayCounts {
  std::uint64_t frames = 0, found = 0, valid = 0, unreadable = 0, dropped = 0;
  std::vector<double> process_us;
};

/// Overlay pictures FOLDER/NNNNNN.png.
class OverlayWriter {
 public:
  OverlayWriter(std::string folder, const CameraModel& camera, const LandmarkGeometry& landmark)
      : folder_(std::move(folder)), camera_(camera), landmark_(landmark) {
    if (!folder_.empty() && mkdir(folder_.c_str(), 0777) != 0 && errno != EEXIST)
      throw StartupError(ExitStatus::kWorkFailed, fmt::format("{} cannot be made: {}", folder_, std::strerror(errno)));
  }
  /// Of the frames from now on.
  void look_through(const CameraModel& camera) { camera_ = camera; }
  /// \param by  what processed the frame
  void write(const Frame& frame, const Report& report, const FrameProcessor& by) {
    if (folder_.empty()) return;
    const auto failed = by.failed_search();
    draw_overlay(frame.luma, report, by.last_observation(), failed ? &*failed : nullptr, camera_, landmark_, 0,
                 picture_);
    const std::string path = fmt::format("{}/{:06}.png", folder_, frame.number);
    const auto written = write_png_rgb(path, picture_.pixels, {picture_.width_px, picture_.height_px});
    if (!written)
      throw StartupError(ExitStatus::kWorkFailed,
                         fmt::format("{} cannot be written: {}", path, std::strerror(written.error().os_errno)));
  }

 private:
  std::string folder_;
  CameraModel camera_;
  LandmarkGeometry landmark_;
  RgbPicture picture_;
};

std::optional<EulerConvention> euler_convention(const std::string& name) {
  if (name.empty()) return std::nullopt;
  return name == "fanuc" ? EulerConvention::kFanuc : name == "kuka" ? EulerConvention::kKuka : EulerConvention::kZyx;
}

/// Rows in the chosen format.
class PoseRows {
 public:
  PoseRows(const std::string& path, bool tum) : file_(path), tum_(tum) {
    if (!tum_) file_.write(pose_csv_header());
  }
  /// A trajectory has no column that says what must not be acted on: it holds valid poses alone.
  void add(const Report& report) {
    const WireReport row = wire_report(report);
    if (!tum_) file_.write(format_pose_csv_row(row));
    if (tum_ && row.valid) file_.write(format_tum_row(row));
  }
  OutputFile& file() noexcept { return file_; }

 private:
  OutputFile file_;
  bool tum_;
};

void print_summary(ReplayCounts& counts) {
  double median_us = 0;
  if (!counts.process_us.empty()) {
    const auto middle = counts.process_us.begin() + static_cast<std::ptrdiff_t>(counts.process_us.size() / 2);
    std::nth_element(counts.process_us.begin(), middle, counts.process_us.end());
    median_us = *middle;
  }
  std::string line = fmt::format("{} frames, landmark found in {}, valid in {}, median {:.2f} ms per frame",
                                 counts.frames, counts.found, counts.valid, median_us / 1000);
  if (counts.unreadable > 0) line += fmt::format(", {} unreadable left out", counts.unreadable);
  if (counts.dropped > 0) line += fmt::format(", {} dropped", counts.dropped);
  fmt::print(stderr, "{}\n", line);
}

/// The recorded time of a frame: with --realtime the lease carries the instant of its turn instead.
class RecordedTimes {
 public:
  RecordedTimes(const std::string& recording, bool needed) {
    if (needed) frames_ = read_recording_index(recording).frames;
  }
  Frame stamped(const Frame& frame) const {
    Frame copy = frame;
    const auto at = std::lower_bound(frames_.begin(), frames_.end(), frame.number,
                                     [](const RecordedFrame& f, std::uint64_t number) { return f.number < number; });
    if (at != frames_.end()) copy.set_exposure(MonoTime(at->recorded_at));
    return copy;
  }

 private:
  std::vector<RecordedFrame> frames_;
};

void check_replay_files(const ReplayArguments& arguments, const Config& config) {
  check_recording(arguments.recording);
  std::vector<std::string> inputs = files_of(config, {arguments.recording}, arguments.camera);
  inputs.insert(inputs.end(), {arguments.recording, arguments.config});
  check_outputs({{"--out", arguments.out.empty() ? "-" : arguments.out},
                 {"--out-world", arguments.out_world},
                 {"--out-track", arguments.out_track},
                 {"--overlay", arguments.overlay_folder}},
                inputs);
}

void run_replay(const ReplayArguments& arguments) {
  const Config config = arguments.config.empty() ? Config{} : read_config(arguments.config);
  check_replay_files(arguments, config);
  RecordingOptions recording_options;
  recording_options.pace = arguments.realtime ? RecordingPace::kRealTime : RecordingPace::kEveryFrame;
  RecordingSource source(arguments.recording, recording_options);
  CameraCalibration calibration = recording_calibration(arguments.recording, arguments.camera, config);
  choose_zoom(calibration, config.pan_tilt, source.tells_zoom());
  const CameraModel& camera = calibration.camera;
  check_picture_size(source, camera, arguments.recording);
  LocaliserOptions options = localiser_options(config);
  options.intrinsics = calibration.record.covariance;
  LensExchange new_lenses;
  std::optional<LensesByFrame> lenses;
  if (calibration.zoom) {
    options.new_lenses = &new_lenses;
    lenses.emplace(*calibration.zoom, options);
  }
  const auto localiser = make_localiser(camera, options);
  const RecordedTimes times(arguments.recording, arguments.realtime);
  OverlayWriter overlay(arguments.overlay_folder, camera, options.seeker.landmark);
  PoseRows rows(arguments.out, arguments.format == "tum");
  const BodyGeometry body = body_geometry(config.body);
  const WorldRowsOptions world_options{options.trust.max_ambiguity,
                                       arguments.of_frame == "body" ? std::optional(body) : std::nullopt,
                                       euler_convention(arguments.euler)};
  WorldRows world(arguments.out_world, WorldRows::Kind::kWorld, world_options);
  WorldRows track(arguments.out_track, WorldRows::Kind::kTrack, world_options);

  ReplayCounts counts;
  Progress progress;
  Report report;
  for (;;) {
    const Result<FrameLease> lease = source.next(mono_now() + 1s);
    if (!lease && lease.error().code == Errc::kEndOfStream) break;
    if (!lease && lease.error().code == Errc::kNoFrame) continue;
    ++counts.frames;
    if (!lease) {
      progress.clear();
      if (!arguments.keep_going)
        throw StartupError(
            ExitStatus::kWorkFailed,
            fmt::format("{}: repair the recording, or leave such frames out with --keep-going", source.last_failure()));
      fmt::print(stderr, "ninedot: {}: left out\n", source.last_failure());
      ++counts.unreadable;
      continue;
    }
    counts.dropped += lease->dropped_before;
    const Frame frame = times.stamped(lease->frame);
    if (lenses) overlay.look_through(lenses->serve(frame).value_or(camera));
    const Fix& fix = localiser->process(frame);
    const ReportContext context{.now = frame.exposed_at(), .body = &body};
    report = next_report(report, frame, fix, context);
    counts.process_us.push_back(std::chrono::duration<double, std::micro>(report.process_time).count());
    if (!fix.landmarks.empty()) {
      ++counts.found;
      if (report.valid) ++counts.valid;
      for (const LandmarkFix& landmark : fix.landmarks) rows.add(with_pose_of(report, frame, landmark, context));
    }
    world.add(frame, fix);
    track.add(frame, fix);
    overlay.write(frame, report, *localiser);
    if (progress.is_due()) progress.show(fmt::format("frame {} of {}", counts.frames, source.frame_count()));
  }
  finish_together({&rows.file(), world.file(), track.file()});
  progress.clear();
  print_summary(counts);
  if (const std::string shutter = row_time_text(report.row_time); !shutter.empty()) fmt::print(stderr, "{}\n", shutter);
}

}  // namespace

void add_replay_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("replay", "Compute the poses of a recording");
  const auto arguments = std::make_shared<ReplayArguments>();
  const auto add_named = [&](const char* name, std::string& path, const char* meaning) {
    return command->add_option(name, path, meaning)->check(is_named());
  };
  add_named("RECORDING", arguments->recording, "folder with frames/, or a .y4m file")->required();
  add_named("--config", arguments->config, "landmark, map and solver; default: the default landmark");
  add_named("--camera", arguments->camera,
            "calibration; default: camera.yaml of the recording, then that of the configuration");
  add_named("--out", arguments->out, "file for the poses; default: standard output");
  add_named("--out-world", arguments->out_world, "file for the camera's poses in the world (the map's)");
  add_named("--out-track", arguments->out_track, "file for the same, filtered over time, with velocity");
  command->add_option("--frame", arguments->of_frame, "whose place these two have: camera (default), or body: [body]")
      ->check(CLI::IsMember({"camera", "body"}));
  command->add_option("--euler", arguments->euler, "adds their angles with 1-sigmas: zyx, fanuc, or kuka")
      ->check(CLI::IsMember({"zyx", "fanuc", "kuka"}));
  command->add_option("--format", arguments->format, "csv (default), or tum: timestamp x y z qx qy qz qw")
      ->check(CLI::IsMember({"csv", "tum"}));
  add_named("--overlay", arguments->overlay_folder, "folder for pictures that show what was found");
  command->add_flag("--realtime", arguments->realtime, "frames come at their recorded times, the newest wins");
  command->add_flag("--keep-going", arguments->keep_going, "leave out pictures that cannot be read");
  command->callback([arguments] { run_replay(*arguments); });
}

}  // namespace ninedot
