#include "outputs/head_output.h"

#include <Eigen/Geometry>

namespace ninedot {
namespace {

AimSight sight_of(const Report& report) noexcept {
  AimSight sight;
  // Of two poses that fit alike both say where the landmark is; only its orientation is in doubt.
  sight.valid = report.valid;
  sight.exposed_at = report.exposed_at;
  const auto& [w, x, y, z] = report.camera_in_landmark.quaternion_wxyz;
  const Eigen::Vector3d camera_landmark_m(report.camera_in_landmark.position_m.data());
  sight.landmark_camera_m = Eigen::Quaterniond(w, x, y, z).conjugate() * -camera_landmark_m;
  return sight;
}

HeadSnapshot snapshot_at_the_start(const PanTilt& head) noexcept {
  HeadSnapshot snapshot;
  snapshot.track = HeadTrack(head.state().angles);
  return snapshot;
}

}  // namespace

HeadOutput::HeadOutput(const CameraModel& camera, const AimOptions& options, PanTilt& head, const DigitalInput* inhibit,
                       const AimOrder& first_order) noexcept
    : aimer_(camera, options, head.state().angles),
      arrival_(options),
      head_(head),
      inhibit_(inhibit),
      orders_(first_order),
      snapshots_(snapshot_at_the_start(head)) {}

void HeadOutput::take(const Report& newest, bool is_new, MonoTime now) noexcept {
  const AimOrder order = orders_.take();
  const HeadState state = head_.state();
  const bool inhibited = inhibit_ != nullptr && inhibit_->is_active();
  // What an older report shows was followed when it was new.
  const AimSight sight = is_new ? sight_of(newest) : AimSight{};
  const AimStep step = aimer_.step(now, state.angles, sight, order, inhibited);
  move(step.command, inhibited);
  const bool limited = step.limited || state.limited;

  HeadSnapshot snapshot;
  snapshot.track = aimer_.track();
  snapshot.limited = limited;
  snapshot.failed = state.failed;
  snapshot.inhibited = inhibited;
  snapshot.order = order.number;
  snapshot.progress = arrival_.step(now, order, {state.angles, step.at_goal, limited, state.failed, inhibited});
  snapshot.losses = state.losses;
  snapshot.pulse_error_p99 = state.pulse_error_p99;
  snapshot.pulse_error_max = state.pulse_error_max;
  snapshots_.put(snapshot);
}

void HeadOutput::move(const HeadAngles& command, bool inhibited) noexcept {
  // Once: a head on a slow line has more to do than to hear it again with every frame.
  if (!inhibited)
    head_.move_to(command);
  else if (!stopped_)
    head_.stop();
  stopped_ = inhibited;
}

}  // namespace ninedot
