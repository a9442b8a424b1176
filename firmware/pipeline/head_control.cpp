#include "pipeline/head_control.h"

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

}  // namespace

HeadControl::HeadControl(const CameraModel& camera, const AimOptions& options, PanTilt& head,
                         const DigitalInput* inhibit, const AimOrder& first_order) noexcept
    : aimer_(camera, options), head_(head), inhibit_(inhibit), order_(first_order), next_{options.neutral, false} {}

void HeadControl::aim(MonoTime now, Report& report) noexcept {
  const HeadState state = head_.state();
  report.inhibited = inhibit_ != nullptr && inhibit_->is_active();
  next_ = aimer_.step(now, state.angles, sight_of(report), order_.read(), report.inhibited);
  const HeadAngles shown = report.valid ? aimer_.head_at(report.exposed_at) : state.angles;
  report.pan_rad = shown.pan_rad;
  report.tilt_rad = shown.tilt_rad;
  report.has_head = true;
  report.servo_limit = next_.limited || state.limited;
  report.servo_fault = state.failed;
}

void HeadControl::move() noexcept {
  // Asked again: the input may have changed while the frame was processed.
  const bool inhibited = inhibit_ != nullptr && inhibit_->is_active();
  // Once: a head on a slow line has more to do than to hear it again with every frame.
  if (!inhibited)
    head_.move_to(next_.command);
  else if (!stopped_)
    head_.stop();
  stopped_ = inhibited;
}

}  // namespace ninedot
