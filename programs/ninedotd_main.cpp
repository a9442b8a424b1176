// The service. Its main() is the architecture: configuration -> source -> localiser -> frame loop, which publishes into
// one mailbox; and the outputs that are fed from it: registers, which the Modbus servers read when they answer, the
// head in a thread of its own, and the main thread's list, which it works through until a signal comes.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "config/config.h"
#include "drivers/posix/board_identity.h"
#include "drivers/posix/realtime.h"
#include "outputs/output_thread.h"
#include "outputs/wire_output.h"
#include "programs/assembly/input_files.h"
#include "programs/assembly/localiser_options.h"
#include "programs/assembly/make_localiser.h"
#include "programs/assembly/modbus_options.h"
#include "programs/assembly/motion_options.h"
#include "programs/assembly/open_head.h"
#include "programs/assembly/open_source.h"
#include "programs/assembly/zoom_choice.h"
#include "programs/display/live_display.h"
#include "programs/program.h"
#include "programs/service/device_identity.h"
#include "programs/service/lens_maker.h"
#include "programs/service/main_outputs.h"
#include "programs/service/map_reloader.h"
#include "programs/service/open_tap.h"
#include "programs/service/service_watch.h"
#include "programs/service/tap_output.h"

namespace ninedot {
namespace {

std::vector<std::string> how_to_read(const ModbusOptions& options) {
  std::vector<std::string> lines{""};
  for (const std::string& command : reading_commands(options)) lines.push_back("read it with:  " + command);
  lines.push_back("all registers: ninedot registers          Ctrl-C ends");
  return lines;
}

/// Sends the head to its parking place and waits until it stands there, for a few seconds at most: what stops the
/// service does not wait for ever.
void park(HeadOutput& head, const Mailbox<Report>& reports) {
  constexpr std::chrono::seconds kLongest{5};  // half of TimeoutStopSec of the systemd unit
  constexpr std::uint32_t kNumber = std::numeric_limits<std::uint32_t>::max();
  head.order({true, {}, kNumber, true});
  const MonoTime until = mono_now() + kLongest;
  while (mono_now() < until) {
    const ReportHead now = reports.read().head;
    if (now.order == kNumber && (now.progress == OrderProgress::kDone || now.progress == OrderProgress::kFailed))
      return;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
}

void run_service(const std::string& config_path, bool live) {
  ConfigProblems keys;
  const Config config = read_config(config_path, keys);
  refuse_first(keys, config_path);
  const TerminationSignals signals;  // before the first thread
  // With larger ones the service works as well; less memory is left to others.
  static_cast<void>(use_small_thread_stacks());

  CameraCalibration calibration;
  const OpenedSource camera = open_calibrated_source(config, FrameDemand::kNewest, calibration);
  const bool head_has_zoom = head_tells_zoom(config.pan_tilt);
  choose_zoom(calibration, config.pan_tilt, head_has_zoom || camera.tells_zoom);
  const CameraModel& model = calibration.camera;
  RoomMapHandoff maps;
  LocaliserOptions localiser_settings = localiser_options(config);
  localiser_settings.new_maps = &maps;
  localiser_settings.intrinsics = calibration.record.covariance;
  LensExchange lenses;
  if (calibration.zoom) localiser_settings.new_lenses = &lenses;
  const auto localiser = make_localiser(model, localiser_settings);
  const OpenedHead head = open_head(config, model, camera.head_line, calibration.zoom.has_value());
  Mailbox<Report> reports;
  Mailbox<Health> health;
  const bool wants_lock = config.service.lock_memory;
  const Result<void> locked = wants_lock ? lock_memory() : Result<void>();
  const std::chrono::duration<double> stall(config.camera.stall_frames / config.camera.rate_hz);
  FrameLoopOptions loop_options;
  loop_options.stall_after =
      std::max(loop_options.stall_after, std::chrono::duration_cast<std::chrono::nanoseconds>(stall));
  loop_options.memory_locked = wants_lock && locked.has_value();
  loop_options.body = body_geometry(config.body);
  if (head.output) loop_options.head = &head.output->snapshots();
  loop_options.zoom_of_head = calibration.zoom && head_has_zoom;
  const OpenedTap tap = open_tap(config, model, localiser_settings.seeker.landmark);
  loop_options.observer = tap.observer.get();
  FrameLoop frames(*camera.frames, *localiser, reports, health, loop_options);
  const BoardIdentity board = read_board_identity();
  ModbusOptions modbus = modbus_options(config);
  modbus.identity = device_identity(board);
  const WireOutput registers(reports, health, pose_output(config));
  ModbusServer server(registers, modbus);

  std::optional<LiveDisplay> display;
  if (live) display.emplace(stdout, how_to_read(modbus));
  ServiceLog log(display ? &*display : nullptr);
  // Below the frame loop, which it must not hold up; the frame loop never waits for it (base/handoff.h).
  RealtimeThread head_priority(std::max(0, config.service.realtime_priority - 1), "head");
  std::optional<OutputThread> head_thread;
  if (head.output) head_thread.emplace(reports, *head.output, head_priority, HeadOutput::kPeriod);
  // First, so that it hears the lines of the start.
  std::vector<std::unique_ptr<Output>> outputs;
  if (tap.writer) {
    auto tap_output = std::make_unique<TapOutput>(*tap.writer, server, modbus.codec, frames);
    log.tell(tap_output.get());
    outputs.push_back(std::move(tap_output));
  }
  RealtimeThread thread(config.service.realtime_priority, "frames");
  const Result<void> realtime = frames.start(thread);
  log.write(fmt::format("ninedot {}: {}, {}x{}, solver {}", NINEDOT_VERSION,
                        config.camera.device.empty() ? config.camera.source : config.camera.device, model.width_px,
                        model.height_px, config.pose.solver));
  if (!board.model.empty() || !board.serial.empty())
    log.write(fmt::format("board: {}, serial number {}", board.model.empty() ? "unknown" : board.model,
                          board.serial.empty() ? "not told" : board.serial));
  if (!camera.description.empty()) log.write("camera: " + camera.description);
  if (!camera.refusal.empty()) log.note_camera_absent(camera.refusal);
  log.write("frame loop: " + realtime_text(config.service.realtime_priority, realtime));
  log.write("memory: " + memory_text(wants_lock, locked));
  for (const std::string& command : reading_commands(modbus)) log.write("read the position with: " + command);
  if (tap.writer) log.write("tap: " + config.tap.path);
  if (!tap.refusal.empty()) log.write("no tap: " + tap.refusal);
  if (!modbus.tcp && !modbus.rtu) log.write("no Modbus server: add [modbus.tcp] or [modbus.rtu] to the configuration");

  // A further output is a further entry here; one that waits for others gets an OutputThread like the head.
  outputs.push_back(std::make_unique<LogOutput>(log, frames));
  if (head.output) outputs.push_back(std::make_unique<CommandOutput>(server, *head.output));
  if (head.status_led) outputs.push_back(std::make_unique<LedOutput>(*head.status_led));
  if (head.lone_power) outputs.push_back(std::make_unique<PowerOutput>(*head.lone_power));
  outputs.push_back(std::make_unique<DeviceLogOutput>(log, head.devices, server));
  if (display) outputs.push_back(std::make_unique<LiveOutput>(*display, server, modbus.codec));
  auto map_output = std::make_unique<MapReloader>(config, keys, config_path, maps, log);
  MapReloader& map = *map_output;
  outputs.push_back(std::move(map_output));
  if (calibration.zoom)
    outputs.push_back(std::make_unique<LensMaker>(*calibration.zoom, localiser_settings, lenses, log));
  watch_until_signalled(signals, {frames, reports, outputs}, [&] { map.request(); });
  if (head.output && config.pan_tilt.park_at_shutdown) park(*head.output, reports);
  log.tell(nullptr);
  frames.stop();
}

}  // namespace
}  // namespace ninedot

// NOLINTNEXTLINE(bugprone-exception-escape): CLI11 throws here for a mistake in the declarations below, before any run
int main(int argc, char** argv) {
  CLI::App app{"Camera pose from a nine-dot landmark, over Modbus.", "ninedotd"};
  std::string config_path;
  bool live = false;
  app.add_option("--config", config_path, "configuration file; `ninedot check` tells what is wrong with one")
      ->required();
  app.add_flag("--live", live, "show pose, rate, latency and clients; in a pipe one line a second");
  return ninedot::run_program(app, argc, argv, [&] { ninedot::run_service(config_path, live); });
}
