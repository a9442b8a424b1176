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
#include "programs/assembly/localiser_options.h"
#include "programs/assembly/make_localiser.h"
#include "programs/assembly/open_source.h"
#include "programs/commands/head_tour_drive.h"
#include "programs/commands/own_head.h"
#include "programs/commands/progress.h"
#include "programs/commands/service_head.h"
#include "programs/commands/tapped_source.h"

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

/// "pan -45 to 45 deg, tilt -20 to 20 deg"
std::string limits_text(const PanTiltConfig& head) {
  return fmt::format("pan {:g} to {:g} deg, tilt {:g} to {:g} deg", head.pan.min_deg, head.pan.max_deg,
                     head.tilt.min_deg, head.tilt.max_deg);
}

class Tour {
 public:
  Tour(const Config& config, const LiveTourOptions& tour, const TerminationSignals& signals)
      : signals_(signals), news_(tour.news) {
    open_camera(config, tour);
    const LocaliserOptions options = localiser_options(config);
    landmark_ = options.seeker.landmark;
    localiser_ = make_localiser(calibration_.camera, options);
    fmt::print(stderr,
               "the head will move, within {}: it looks for a landmark and makes some {} stops before it; Ctrl-C stops "
               "it\n",
               limits_text(config.pan_tilt), tour.columns * (2 * tour.rows - 1));
    if (tour.through_service.empty())
      head_ = open_own_head(config, calibration_.camera, source_.head_line);
    else
      head_ = std::make_unique<ServiceHead>(config);
    drive_.emplace(tour_options(config, calibration_.camera, tour.columns, tour.rows), *head_);
  }

  LiveTour run() {
    LiveTour result;
    last_frame_at_ = answered_at_ = mono_now();
    while (!drive_->is_over() && !result.is_interrupted) {
      result.is_interrupted = signals_.wait(0ns) != 0 || (news_ != nullptr && news_->is_broken());
      if (!result.is_interrupted) look();
    }
    result.frames = drive_->frames();
    drive_.reset();
    head_.reset();  // at once: what follows takes its time
    return result;
  }

  const LandmarkGeometry& landmark() const { return landmark_; }

 private:
  void open_camera(const Config& config, const LiveTourOptions& tour) {
    if (!tour.through_service.empty()) {
      calibration_ = read_camera_calibration(config.camera);
      source_ = open_tapped_source(tour.through_service, config);
      return;
    }
    check_no_service(config.modbus_tcp);
    source_ = open_calibrated_source(config, FrameDemand::kNewest, calibration_);
    if (!source_.refusal.empty()) give_up(source_.refusal);
  }

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
    const std::string problem = head_->problem();
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
    const HeadTour& tour = drive_->tour();
    const std::size_t planned = tour.stops_planned();
    const bool is_seen = !drive_->frames().empty() && !drive_->frames().back().seen.empty();
    if (news_ != nullptr && news_->is_due())
      news_->moving({tour.part(), tour.stops_made(), planned, drive_->told(), is_seen, drive_->is_inhibited()});
    if (!progress_.is_due()) return;
    progress_.show(fmt::format("{}: stop {}{}, pan {:.1f}, tilt {:.1f} deg, {}; Ctrl-C stops the head",
                               name_of(tour.part()), tour.stops_made() + 1,
                               planned > 0 ? fmt::format(" of {}", planned) : std::string(),
                               drive_->told().pan_rad * kDegPerRad, drive_->told().tilt_rad * kDegPerRad,
                               drive_->is_inhibited()     ? "inhibited"
                               : drive_->frames().empty() ? "no picture yet"
                               : is_seen                  ? "landmark in sight"
                                                          : "no landmark"));
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
  HeadNews* const news_;
  CameraCalibration calibration_;
  OpenedSource source_;
  LandmarkGeometry landmark_;
  std::unique_ptr<FrameProcessor> localiser_;
  std::unique_ptr<TouredHead> head_;
  std::optional<HeadTourDrive> drive_;
  Progress progress_;
  MonoTime last_frame_at_{}, answered_at_{};
  bool was_inhibited_ = false;
};

}  // namespace

LiveTour tour_live(const Config& config, const LiveTourOptions& options, const TerminationSignals& signals,
                   LandmarkGeometry& landmark) {
  check_usage(config);
  Tour tour(config, options, signals);
  landmark = tour.landmark();
  return tour.run();
}

}  // namespace ninedot
