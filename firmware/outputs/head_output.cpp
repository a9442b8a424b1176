#include "outputs/head_output.h"

#include <Eigen/Core>

namespace ninedot {
namespace {

using Sights = InlineVector<AimSight, kMostReportSights>;

/// Of the newest frame: what an older report shows was followed when it was new.
Sights sights_of(const Report& report) noexcept {
  Sights sights;
  for (const ReportSight& sight : report.sights)
    (void)sights.try_push_back({sight.id, sight.exposed_at, Eigen::Vector3d(sight.landmark_camera_m.data())});
  return sights;
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
      park_(options.park),
      arrival_(options),
      head_(head),
      inhibit_(inhibit),
      orders_(first_order),
      snapshots_(snapshot_at_the_start(head)) {}

void HeadOutput::take(const Report& newest, bool is_new, MonoTime now) noexcept {
  const AimOrder order = orders_.take();
  const HeadState state = head_.state();
  const bool inhibited = inhibit_ != nullptr && inhibit_->is_active();
  const Sights sights = is_new ? sights_of(newest) : Sights{};
  const AimStep step = aimer_.step(now, state, {is_new, sights.span()}, order, inhibited);
  move(step.command, inhibited);
  const bool limited = step.limited || state.limited;

  HeadSnapshot snapshot;
  snapshot.track = aimer_.track();
  snapshot.state = step.state;
  snapshot.sweep = aimer_.sweep().duration();
  snapshot.limited = limited;
  snapshot.failed = state.failed;
  snapshot.inhibited = inhibited;
  snapshot.order = order.number;
  snapshot.progress =
      arrival_.step(now, as_set_point(order), {state.angles, step.at_goal, limited, state.failed, inhibited});
  snapshot.losses = state.losses;
  snapshot.servos = state.servos;
  snapshot.zoom = state.zoom;
  snapshot.pulse_error_p99 = state.pulse_error_p99;
  snapshot.pulse_error_max = state.pulse_error_max;
  snapshots_.put(snapshot);
}

/// Who is sent to park has arrived when he stands there.
AimOrder HeadOutput::as_set_point(const AimOrder& order) const noexcept {
  return order.park ? AimOrder{false, park_, order.number} : order;
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
