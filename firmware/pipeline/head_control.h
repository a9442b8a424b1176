#pragma once
/// The head's part in the frame loop: what the frame shows -> aiming step -> report -> head.
#include "aim/aimer.h"
#include "base/mailbox.h"
#include "ports/digital_io.h"
#include "ports/pan_tilt.h"
#include "proto/report.h"

namespace ninedot {

/// Memory: none after construction. Threads: `order` one caller of any thread, the others the frame loop.
class HeadControl {
 public:
  /// \param inhibit  while it is active nothing moves; may be null. Both must outlive this.
  HeadControl(const CameraModel& camera, const AimOptions& options, PanTilt& head, const DigitalInput* inhibit,
              const AimOrder& first_order) noexcept;

  /// Takes effect at the next frame.
  void order(const AimOrder& order) noexcept { order_.publish(order); }

  /// Decides where to go next. Pan and tilt in the report become those at which the head stood when its frame was
  /// exposed; without a valid pose, those at which it stands now.
  void aim(MonoTime now, Report& report) noexcept;
  /// Carries the decision out; after the report is published, because a bus to the servos may take a millisecond.
  void move() noexcept;

  HeadState state() const noexcept { return head_.state(); }

 private:
  Aimer aimer_;
  PanTilt& head_;
  const DigitalInput* const inhibit_;
  Mailbox<AimOrder> order_;
  AimStep next_;
  bool stopped_ = false;
};

}  // namespace ninedot
