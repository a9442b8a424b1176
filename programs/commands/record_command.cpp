// `ninedot record`: frames of the configured source into a recording, until --frames are there, the source ends or the
// user stops.
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "base/startup_error.h"
#include "config/config.h"
#include "drivers/posix/signals.h"
#include "drivers/posix/text_file.h"
#include "drivers/recording/recording_index.h"
#include "drivers/recording/recording_writer.h"
#include "programs/assembly/input_files.h"
#include "programs/assembly/open_head.h"
#include "programs/assembly/open_source.h"
#include "programs/commands/commands.h"
#include "programs/commands/named_option.h"
#include "programs/commands/source_failure.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

struct RecordArguments {
  std::string config, out;
  std::uint64_t frames = 0;  ///< 0 = until the end
  bool grey = false;
};

/// The calibration to record beside the pictures, as its file has it, with all that it says of itself: empty where the
/// camera has none yet (one records in order to calibrate). \param record  out: of it, where there is one
std::string calibration_text(const CameraConfig& config, std::optional<CalibrationRecord>& record) {
  const bool has_own =
      config.source == "simulated" ||
      (config.source == "recording" && ::access(recording_camera_file(config.device).c_str(), F_OK) == 0);
  if (config.calibration.empty() && !has_own) return {};
  const CameraCalibration calibration = read_camera_calibration(config);
  record = calibration.record;
  if (config.calibration.empty() && config.source == "simulated") return format_camera(calibration.camera, "simulated");
  return read_text_file(calibration_file(config), kMaxFile_bytes);
}

void show_progress(const RecordArguments& arguments, std::uint64_t count) {
  static const bool is_terminal = ::isatty(STDERR_FILENO) == 1;
  if (!is_terminal) return;
  if (arguments.frames > 0)
    fmt::print(stderr, "\rframe {} of {}", count, arguments.frames);
  else
    fmt::print(stderr, "\rframe {}, Ctrl-C ends", count);
}

double zoom_at(const PanTilt& head, MonoTime time) {
  const std::optional<ZoomStand> zoom = head.state().zoom;
  return zoom ? zoom->at(time) : std::numeric_limits<double>::quiet_NaN();
}

void run_record(const RecordArguments& arguments) {
  const Config config = read_config(arguments.config);
  const TerminationSignals signals;  // before the first thread
  std::optional<CalibrationRecord> record;
  const std::string calibration = calibration_text(config.camera, record);
  OpenedSource source = open_source(config, FrameDemand::kEveryFrame, record ? &*record : nullptr);
  const std::unique_ptr<PanTilt> zoom_teller = open_zoom_teller(config);
  RecordingWriter writer(arguments.out, calibration, write_to_disk, zoom_teller || source.tells_zoom);

  std::uint64_t lost = 0, without_zoom = 0;
  MonoTime last_frame_at = mono_now();
  while (signals.wait(0ns) == 0 && (arguments.frames == 0 || writer.frame_count() < arguments.frames)) {
    Result<FrameLease> frame = source.frames->next(mono_now() + 200ms);
    if (!frame) {
      if (frame.error().code == Errc::kEndOfStream) break;
      const std::string failure = why_source_failed(source, frame.error(), last_frame_at);
      if (failure.empty()) continue;
      throw StartupError(ExitStatus::kWorkFailed, failure);
    }
    last_frame_at = mono_now();
    lost += frame->dropped_before;
    if (arguments.grey) frame->frame.chroma = {};
    if (zoom_teller) frame->frame.zoom = zoom_at(*zoom_teller, frame->frame.exposed_at());
    if (zoom_teller && std::isnan(frame->frame.zoom)) ++without_zoom;
    const Result<std::uint64_t> number = writer.add(*frame);
    if (!number)
      throw StartupError(
          ExitStatus::kWorkFailed,
          fmt::format("{}: {}; {}", arguments.out, std::strerror(number.error().os_errno),
                      writer.frame_count() > 0 ? fmt::format("the {} frames before are kept", writer.frame_count())
                                               : std::string("nothing was recorded")));
    show_progress(arguments, writer.frame_count());
  }
  if (::isatty(STDERR_FILENO) == 1) fmt::print(stderr, "\r\x1b[K");
  if (writer.frame_count() == 0)
    throw StartupError(ExitStatus::kWorkFailed, "stopped before the first frame; nothing was recorded");
  fmt::print("{}: {} frames{}{}\n", arguments.out, writer.frame_count(),
             lost > 0 ? fmt::format(", {} lost", lost) : std::string(),
             without_zoom > 0 ? fmt::format(", of {} the zoom is not known", without_zoom) : std::string());
}

}  // namespace

void add_record_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("record", "Record the frames of the configured camera");
  const auto arguments = std::make_shared<RecordArguments>();
  command->add_option("--config", arguments->config, "configuration file: its [camera] is recorded")
      ->required()
      ->check(is_named());
  command->add_option("--out", arguments->out, "a new or empty folder")->required()->check(is_named());
  command->add_option("--frames", arguments->frames, "stop after so many; default: at the end, or at Ctrl-C")
      ->check(CLI::Range(std::uint64_t{1}, std::uint64_t{999'999'999}));
  command->add_flag("--grey", arguments->grey, "leave out the colour: the pose needs none, and the files are smaller");
  command->callback([arguments] { run_record(*arguments); });
}

}  // namespace ninedot
