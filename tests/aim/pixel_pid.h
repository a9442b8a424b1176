#pragma once
/// The rival: a PID controller on how far the landmark is from the middle of the picture, whose output is the head's
/// rate; no kinematics, no delay, no prediction. Without a sight it stays.
///
/// Its gains: the best that a coarse search by hand found for a hobby servo's passes at 1 m/s and at 0.3 m/s and a step
/// of 20 deg. The rival with pictures in its loop has gains from a grid: `bench_aiming --tune`.
#include "tests/aim/closed_loop.h"

namespace ninedot::test {

struct PidGains {
  double p_per_s = 9, i_per_s2 = 10, d = 0.05;
};

class PixelPid final : public Controller {
 public:
  explicit PixelPid(const LoopSetup& setup, const PidGains& gains = {})
      : gains_(gains), options_(setup.options), command_(setup.start) {}
  AimStep step(MonoTime now, const HeadState& /*head*/, const AimFrame& frame, const AimOrder& /*order*/,
               bool /*inhibited*/) override {
    const double dt_s = seconds(now, stepped_at_);
    stepped_at_ = now;
    if (frame.is_new && !frame.sights.empty()) {
      const Eigen::Vector3d& p = frame.sights.front().landmark_camera_m;
      const double frame_s = seconds(now, saw_at_);
      pan_.take(gains_, -std::atan2(p.x(), p.z()), frame_s);
      tilt_.take(gains_, -std::atan2(p.y(), p.z()), frame_s);
      saw_at_ = now;
    } else if (frame.is_new) {
      pan_.rate = tilt_.rate = 0;
    }
    command_.pan_rad = moved(command_.pan_rad, pan_.rate, options_.pan, dt_s);
    command_.tilt_rad = moved(command_.tilt_rad, tilt_.rate, options_.tilt, dt_s);
    return {AimState::kTrack, command_, false, false};
  }

 private:
  struct Axis {
    double rate = 0, sum = 0, last = 0;
    void take(const PidGains& gains, double error, double frame_s) {
      sum += error * frame_s;
      rate = gains.p_per_s * error + gains.i_per_s2 * sum + (frame_s > 0 ? gains.d * (error - last) / frame_s : 0);
      last = error;
    }
  };
  static double seconds(MonoTime now, MonoTime before) {
    return before == MonoTime{} ? 0 : std::min(std::chrono::duration<double>(now - before).count(), 0.1);
  }
  static double moved(double angle, double rate, const AimAxis& axis, double dt_s) {
    return std::clamp(angle + std::clamp(rate, -axis.slew_rad_per_s, axis.slew_rad_per_s) * dt_s, axis.min_rad,
                      axis.max_rad);
  }

  const PidGains gains_;
  const AimOptions options_;
  HeadAngles command_;
  Axis pan_, tilt_;
  MonoTime stepped_at_{}, saw_at_{};
};

}  // namespace ninedot::test
