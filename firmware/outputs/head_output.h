#pragma once
/// The pan/tilt head as an output: report -> aiming step -> head. Between reports the head goes on along its way.
///
/// In a thread of its own, because a bus to the servos may take milliseconds, and below the frame loop's priority. The
/// loop is closed through two handoffs, on neither of which anybody waits: orders come in, and what the head does goes
/// out to the frame loop, which stamps the next report with it.
#include "aim/aimer.h"
#include "aim/arrival.h"
#include "aim/head_snapshot.h"
#include "base/handoff.h"
#include "outputs/output.h"
#include "ports/digital_io.h"
#include "ports/pan_tilt.h"

namespace ninedot {

/// Memory: none after construction. Threads: see each method.
class HeadOutput final : public Output {
 public:
  /// With this period the head goes on, and obeys the inhibit input, while no reports come.
  static constexpr std::chrono::milliseconds kPeriod = Sweep::kTick;

  /// \param inhibit  while it is active nothing moves; may be null. Both must outlive this.
  HeadOutput(const CameraModel& camera, const AimOptions& options, PanTilt& head, const DigitalInput* inhibit,
             const AimOrder& first_order) noexcept;

  /// Takes effect at the next report, at the latest after kPeriod; the newest wins. Wait-free. Threads: one, any.
  void order(const AimOrder& order) noexcept { orders_.put(order); }

  /// What the head does, for the frame loop. Threads: `take` of it belongs to the frame loop.
  Handoff<HeadSnapshot>& snapshots() noexcept { return snapshots_; }

  /// Decides where to go next, and goes there. Threads: one, the head's own.
  void take(const Report& newest, bool is_new, MonoTime now) noexcept override;

 private:
  void move(const HeadAngles& command, bool inhibited) noexcept;
  AimOrder as_set_point(const AimOrder& order) const noexcept;

  Aimer aimer_;
  const HeadAngles park_;
  Arrival arrival_;
  PanTilt& head_;
  const DigitalInput* const inhibit_;
  Handoff<AimOrder> orders_;
  Handoff<HeadSnapshot> snapshots_;
  bool stopped_ = false;
};

}  // namespace ninedot
