#include "programs/commands/live_head.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <thread>
#include <utility>

#include "base/startup_error.h"
#include "base/units.h"
#include "calibrate_head/head_sufficiency.h"
#include "config/head_options.h"
#include "drivers/modbus/tcp_server.h"
#include "drivers/posix/listening_program.h"
#include "drivers/posix/realtime.h"
#include "outputs/output_thread.h"
#include "programs/assembly/localiser_options.h"
#include "programs/assembly/make_localiser.h"
#include "programs/assembly/open_head.h"
#include "programs/assembly/open_source.h"
#include "programs/commands/head_tour_drive.h"
#include "programs/commands/progress.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

/// A camera that gives no picture for so long will give none; a head that does not answer likewise.
constexpr auto kPatience = 5s;
/// Ctrl-C is heard as often, at least.
constexpr auto kBetweenLooks = 100ms;

[[noreturn]] void give_up(const std::string& what) { throw StartupError(ExitStatus::kWorkFailed, what); }

void check_usage(const Config& config) {
  if (config.pan_tilt.driver == "none")
    throw StartupError(ExitStatus::kWrongUsage, "there is no head to move: set pan_tilt.driver, or give a recording");
  if (config.camera.source == "recording")
    throw StartupError(ExitStatus::kWrongUsage,
                       "camera.source is \"recording\", which no head moves: name a camera, or give the recording");
  for (const auto& [axis, name] : {std::pair{&config.pan_tilt.pan, "pan"}, std::pair{&config.pan_tilt.tilt, "tilt"}})
    if (axis->max_deg - axis->min_deg < kLeastTravel_rad * kDegPerRad)
      throw StartupError(
          ExitStatus::kWrongUsage,
          fmt::format("[pan_tilt.{}] lets the axis turn by {:g} degrees, from min_deg to max_deg; {:.0f} "
                      "at least are needed to know it",
                      name, axis->max_deg - axis->min_deg, kLeastTravel_rad * kDegPerRad));
}

/// Not every head and camera can be held by one program only, so the port is asked as well.
void check_no_service(const ModbusTcpConfig& tcp) {
  if (!tcp.enabled || try_listen(tcp.listen, tcp.port) || find_listener("ninedotd", tcp.port) == Listening::kNo) return;
  give_up(fmt::format("port {} is a running ninedotd's, which moves the head: stop it first (systemctl stop ninedotd)",
                      tcp.port));
}

/// The service's own first order would be to follow the landmark, by the numbers that are to be found.
Config without_following(Config config) {
  config.pan_tilt.follow = config.pan_tilt.search_at_start = false;
  return config;
}

/// A head with the thread that moves it.
class MovedHead {
 public:
  MovedHead(const Config& config, const CameraModel& camera, const std::shared_ptr<HeadLine>& line)
      : head_(open_head(without_following(config), camera, line, false)),
        priority_(std::max(0, config.service.realtime_priority - 1), "head") {
    thread_.emplace(reports_, *head_.output, priority_, HeadOutput::kPeriod);
  }
  /// No order reaches it any more, and it ends its motion; then its signals and its power go.
  ~MovedHead() {
    thread_.reset();
    head_.servos->stop();
  }
  MovedHead(const MovedHead&) = delete;
  MovedHead& operator=(const MovedHead&) = delete;

  HeadOutput& output() { return *head_.output; }
  /// Of head, inhibit input or lamp: why it is not in use. Empty: all are. \param is_inhibited  an input that is there
  /// keeps the head from being opened
  std::string problem(bool is_inhibited) const {
    for (const WatchedDevice& device : head_.devices) {
      if (is_inhibited && device.name == "pan/tilt") continue;
      if (std::string what = device.problem(); !what.empty()) return fmt::format("{}: {}", device.name, what);
    }
    return {};
  }

 private:
  OpenedHead head_;
  Mailbox<Report> reports_;  // stays empty: nothing is followed
  RealtimeThread priority_;
  std::optional<OutputThread> thread_;
};

/// "pan -45 to 45 deg, tilt -20 to 20 deg"
std::string limits_text(const PanTiltConfig& head) {
  return fmt::format("pan {:g} to {:g} deg, tilt {:g} to {:g} deg", head.pan.min_deg, head.pan.max_deg,
                     head.tilt.min_deg, head.tilt.max_deg);
}

class Tour {
 public:
  Tour(const Config& config, int columns, int rows, const TerminationSignals& signals) : signals_(signals) {
    source_ = open_calibrated_source(config, FrameDemand::kNewest, calibration_);
    if (!source_.refusal.empty()) give_up(source_.refusal);
    const LocaliserOptions options = localiser_options(config);
    landmark_ = options.seeker.landmark;
    localiser_ = make_localiser(calibration_.camera, options);
    fmt::print(stderr,
               "the head will move, within {}: it looks for a landmark and makes some {} stops before it; Ctrl-C stops "
               "it\n",
               limits_text(config.pan_tilt), columns * (2 * rows - 1));
    head_.emplace(config, calibration_.camera, source_.head_line);
    drive_.emplace(tour_options(config, calibration_.camera, columns, rows), head_->output());
  }

  LiveTour run() {
    LiveTour result;
    last_frame_at_ = answered_at_ = mono_now();
    while (!drive_->is_over() && !result.is_interrupted) {
      result.is_interrupted = signals_.wait(0ns) != 0;
      if (!result.is_interrupted) look();
    }
    head_.reset();  // at once: what follows takes its time
    result.frames = drive_->frames();
    return result;
  }

  const LandmarkGeometry& landmark() const { return landmark_; }

 private:
  void look() {
    const Result<FrameLease> lease = source_.frames->next(mono_now() + kBetweenLooks);
    if (!lease) {
      if (lease.error().code == Errc::kEndOfStream) give_up("the camera's pictures are over before the tour is");
      if (mono_now() - last_frame_at_ > kPatience)
        give_up(fmt::format("no picture for {} s: {}", kPatience.count(), lease.error().text));
      // A camera that is lost says so at once.
      if (lease.error().code != Errc::kNoFrame) std::this_thread::sleep_for(kBetweenLooks);
      return;
    }
    last_frame_at_ = mono_now();
    drive_->take(lease->frame, localiser_->process(lease->frame));
    check_head();
    show();
  }

  void check_head() {
    const std::string problem = head_->problem(drive_->is_inhibited());
    if (problem.empty() && (drive_->is_inhibited() || !drive_->is_failing())) answered_at_ = mono_now();
    if (mono_now() - answered_at_ > kPatience)
      give_up(problem.empty() ? "the head does not answer: `ninedot check` looks at its devices" : problem);
    if (drive_->is_inhibited() && !was_inhibited_) {
      progress_.clear();
      fmt::print(stderr, "the inhibit input keeps the head where it is: it goes on when that is released\n");
    }
    was_inhibited_ = drive_->is_inhibited();
  }

  void show() {
    if (!progress_.is_due()) return;
    const HeadTour& tour = drive_->tour();
    const std::size_t planned = tour.stops_planned();
    progress_.show(fmt::format("{}: stop {}{}, pan {:.1f}, tilt {:.1f} deg, {}; Ctrl-C stops the head",
                               name_of(tour.part()), tour.stops_made() + 1,
                               planned > 0 ? fmt::format(" of {}", planned) : std::string(),
                               drive_->told().pan_rad * kDegPerRad, drive_->told().tilt_rad * kDegPerRad,
                               drive_->is_inhibited()                 ? "inhibited"
                               : drive_->frames().empty()             ? "no picture yet"
                               : drive_->frames().back().seen.empty() ? "no landmark"
                                                                      : "landmark in sight"));
  }

  static const char* name_of(HeadTour::Part part) {
    switch (part) {
      case HeadTour::Part::kFind:
        return "looking for a landmark";
      case HeadTour::Part::kReach:
        return "how far it stays in sight";
      case HeadTour::Part::kGrid:
        return "stops";
      case HeadTour::Part::kHome:
        return "going back";
    }
    return "";
  }

  const TerminationSignals& signals_;
  CameraCalibration calibration_;
  OpenedSource source_;
  LandmarkGeometry landmark_;
  std::unique_ptr<FrameProcessor> localiser_;
  std::optional<MovedHead> head_;
  std::optional<HeadTourDrive> drive_;
  Progress progress_;
  MonoTime last_frame_at_{}, answered_at_{};
  bool was_inhibited_ = false;
};

}  // namespace

LiveTour tour_live(const Config& config, int columns, int rows, const TerminationSignals& signals,
                   LandmarkGeometry& landmark) {
  check_usage(config);
  check_no_service(config.modbus_tcp);
  Tour tour(config, columns, rows, signals);
  landmark = tour.landmark();
  return tour.run();
}

}  // namespace ninedot
