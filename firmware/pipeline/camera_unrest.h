#pragma once
/// How fast a camera has turned of late, and how suddenly, by the landmarks in view: so may those whose motion nobody
/// has measured yet.
#include <algorithm>
#include <chrono>
#include <cmath>

#include "base/mono_time.h"

namespace ninedot {

/// Memory: none. Threads: one caller.
class CameraUnrest {
 public:
  /// A frame begins.
  void begin(MonoTime exposed_at) noexcept {
    const double since_s = std::chrono::duration<double>(exposed_at - at_).count();
    since_s_ = std::clamp(since_s, 0.0, kForgotten_s);
    const double left = since_s >= 0 ? std::exp(-since_s / kForgotten_s) : 0;
    speed_rad_s_ *= left, acceleration_rad_s2_ *= left;
    at_ = exposed_at;
  }
  /// A landmark's direction moved so. \param speed_rad_s  of its ray [rad/s]
  /// \param acceleration_rad_s2  likewise [rad/s^2]; 0: nobody knows
  void note(double speed_rad_s, double acceleration_rad_s2) noexcept {
    speed_rad_s_ = std::max(speed_rad_s_, speed_rad_s);
    acceleration_rad_s2_ = std::max(acceleration_rad_s2_, acceleration_rad_s2);
  }

  /// 1-sigma, each axis, of a landmark of which nothing else is known [rad/s]: a robot turns at 40 degrees per second.
  double speed_rad_s() const noexcept { return std::max(kUsualSpeed_rad_s, speed_rad_s_); }
  /// Likewise [rad/s^2]: as [track] expects of a robot.
  double acceleration_rad_s2() const noexcept { return std::max(kUsualAcceleration_rad_s2, acceleration_rad_s2_); }
  /// What a track of the camera that expects no more than that may be behind: what a speed gained from the frame before
  /// to this one beyond it. [rad/s]
  double unexpected_rad_s() const noexcept { return since_s_ * (acceleration_rad_s2() - kUsualAcceleration_rad_s2); }

 private:
  static constexpr double kForgotten_s = 0.5, kUsualSpeed_rad_s = 0.7, kUsualAcceleration_rad_s2 = 1;

  MonoTime at_{};
  double since_s_ = 0;                                // the frame before
  double speed_rad_s_ = 0, acceleration_rad_s2_ = 0;  // the largest; older ones fade
};

}  // namespace ninedot
