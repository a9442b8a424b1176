#pragma once
/// A plain PID controller on the pixel error, as one would write it without a pose, a model of the servo or of time:
/// what `ninedot simulate --controller pid` measures the project's own controller against.
#include <Eigen/Core>

#include "aim/aimer.h"
#include "aim/head_snapshot.h"
#include "outputs/output.h"
#include "ports/pan_tilt.h"

namespace ninedot {

/// From the error in pixels to the command's rate. The gains of `tests/bench/aiming --tune`: the smallest mean error
/// over a step of 20 deg and a passage at 1 m/s, with a hobby servo and 40 ms of delay at 35 frames a second.
struct PidGains {
  double kp_deg_s_px = 1.0;   ///< degrees a second for each pixel
  double ki_deg_s2_px = 2.0;  ///< and for each pixel that has lasted a second
  double kd_deg_px = 0.04;    ///< and for each pixel a second that the error changes by
};

/// Memory: inside. Threads: one.
class PixelPid final : public Output {
 public:
  /// \param options  limits, fastest turns and the neutral position \param head  must outlive this
  PixelPid(const CameraModel& camera, const AimOptions& options, PanTilt& head, const PidGains& gains) noexcept;

  /// Without a landmark the head stays, and so does the integral.
  void take(const Report& newest, bool is_new, MonoTime now) noexcept override;

  /// What the frame loop is told.
  const HeadSnapshot& snapshot() const noexcept { return snapshot_; }

 private:
  const CameraModel camera_;
  const AimOptions options_;
  PanTilt& head_;
  const PidGains gains_;
  HeadAngles command_;
  Eigen::Vector2d integral_px_s_ = Eigen::Vector2d::Zero(), error_px_ = Eigen::Vector2d::Zero();
  MonoTime seen_at_{};  // 0: not in the frame before
  HeadSnapshot snapshot_;
};

}  // namespace ninedot
