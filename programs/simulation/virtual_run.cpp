// The service's loop (programs/ninedotd_main.cpp, pipeline/frame_loop.cpp) on one thread: frame -> localiser -> report
// -> head. Only the clock differs: it stands still while anything is worked out.
#include "programs/simulation/virtual_run.h"

#include <fmt/format.h>

#include <chrono>

#include "base/contract.h"
#include "base/units.h"
#include "config/head_options.h"
#include "pipeline/next_report.h"
#include "programs/assembly/localiser_options.h"
#include "programs/assembly/make_localiser.h"
#include "programs/assembly/motion_options.h"
#include "programs/assembly/simulation_options.h"

namespace ninedot {

namespace {

/// As of the simulated head and camera.
Config simulated(Config config) {
  config.pan_tilt.driver = "simulated";
  config.camera.source = "simulated";
  return config;
}

}  // namespace

VirtualRun::VirtualRun(const Config& config, const CameraModel& camera, const VirtualRunOptions& options)
    : camera_(simulation_options(config, camera, options.seed), line_, clock_),
      head_(line_, clock_, start_angles(config.pan_tilt)),
      localiser_(make_localiser(camera, localiser_options(simulated(config)))),
      body_(body_geometry(config.body)),
      taken_at_(clock_.now()) {
  const AimOptions aim = aim_options(config.pan_tilt, body_);
  if (options.controller == SimulatedController::kPid)
    controller_ = &pid_.emplace(camera, aim, head_, options.pid);
  else
    controller_ = &servoing_.emplace(camera, aim, head_, nullptr, first_order(config.pan_tilt));
}

const HeadSnapshot& VirtualRun::snapshot() noexcept {
  return servoing_ ? servoing_->snapshots().take() : pid_->snapshot();
}

std::optional<SimulationRow> VirtualRun::next() noexcept {
  for (;;) {
    const Result<FrameLease> lease = camera_.next(taken_at_ + HeadOutput::kPeriod);
    if (!lease && lease.error().code == Errc::kEndOfStream) return std::nullopt;
    taken_at_ = clock_.now();
    if (!lease) {
      controller_->take(report_, false, taken_at_);
      continue;
    }
    const Fix& fix = localiser_->process(lease->frame);
    report_ = next_report(report_, lease->frame, fix, {taken_at_, &snapshot(), lease->dropped_before, &body_});
    controller_->take(report_, true, taken_at_);
    SimulationRow row;
    row.truth = camera_.truth();
    row.command = head_.state().angles;
    row.state = servoing_ ? name_of(snapshot().state) : report_.valid ? "TRACK" : "HOLD";  // a PID knows no more
    row.valid = report_.valid;
    row.found = report_.found;
    if (report_.valid)
      row.pose_error_m = (Eigen::Vector3d(report_.camera_in_world.position_m.data()) - row.truth.camera_m).norm();
    return row;
  }
}

std::string simulation_csv_header() {
  return "t_s,x_mm,y_mm,heading_deg,pan_true_deg,tilt_true_deg,pan_command_deg,tilt_command_deg,state,visible,valid,"
         "centre_error_deg\n";
}

std::string simulation_csv_row(const SimulationRow& row) {
  const SimulationTruth& truth = row.truth;
  return fmt::format("{:.6f},{:.3f},{:.3f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{},{:d},{:d},{:.4f}\n", truth.t_s,
                     truth.body.position_m.x() / kMetresPerMm, truth.body.position_m.y() / kMetresPerMm,
                     truth.body.heading_rad * kDegPerRad, truth.head.pan_rad * kDegPerRad,
                     truth.head.tilt_rad * kDegPerRad, row.command.pan_rad * kDegPerRad,
                     row.command.tilt_rad * kDegPerRad, row.state, truth.visible, row.valid,
                     truth.centre_error_rad * kDegPerRad);
}

}  // namespace ninedot
