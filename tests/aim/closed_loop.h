#pragma once
/// The closed loop without pictures: a robot that drives along a line, a head with the faults of servos, and a camera
/// that says late, and with noise, where it saw the landmark. In virtual time, a millisecond at a time; the controller
/// knows nothing of what is true here.
#include <algorithm>
#include <cmath>
#include <deque>
#include <functional>
#include <numbers>
#include <optional>
#include <vector>

#include "aim/aimer.h"
#include "geometry/body.h"
#include "tests/support/random.h"

namespace ninedot::test {

inline constexpr double kDeg = std::numbers::pi / 180;

/// One axis as it is: an inner motor loop of limited speed and acceleration behind a dead time.
struct ServoFaults {
  double speed_deg_s = 353, acceleration_deg_s2 = 6000;  // 0.17 s for 60 deg
  double dead_band_deg = 0;                              // nearer commands do not start the motor
  double stops_short_deg = 0;                            // so near the motor ends a motion
  double backlash_deg = 0;
  double resolution_deg = 0.01;
  double delay_s = 0.02, period_s = 0.02;  // dead time behind the pulse, and from pulse to pulse
  double scale = 1;                        // degrees that it turns for a degree of command
};

class Servo {
 public:
  Servo(const ServoFaults& faults, double at_rad) : faults_(faults), motor_deg_(at_rad / kDeg), out_deg_(motor_deg_) {
    target_deg_ = motor_deg_;
  }
  void command(double rad) { command_deg_ = rad / kDeg * faults_.scale; }
  void step(double now_s) {
    constexpr double kStep_s = 0.001;
    if (now_s >= pulse_at_s_) {
      pulse_at_s_ += faults_.period_s;
      const double q = faults_.resolution_deg;
      late_.push_back({now_s + faults_.delay_s, std::round(command_deg_.value_or(target_deg_) / q) * q});
    }
    while (!late_.empty() && late_.front().at_s <= now_s) target_deg_ = late_.front().deg, late_.pop_front();
    const double error = target_deg_ - motor_deg_;
    if (!runs_) runs_ = std::abs(error) > std::max(faults_.dead_band_deg, 1e-9);
    if (runs_ && std::abs(error) <= faults_.stops_short_deg) runs_ = false;
    const double brake = std::sqrt(2 * faults_.acceleration_deg_s2 * std::abs(error));
    const double wanted =
        runs_ ? std::copysign(std::min({faults_.speed_deg_s, brake, std::abs(error) / kStep_s}), error) : 0;
    const double most = faults_.acceleration_deg_s2 * kStep_s;
    speed_deg_s_ = std::clamp(wanted, speed_deg_s_ - most, speed_deg_s_ + most);
    motor_deg_ += speed_deg_s_ * kStep_s;
    if (runs_ && std::abs(target_deg_ - motor_deg_) < 1e-6) runs_ = false;
    out_deg_ = std::clamp(out_deg_, motor_deg_ - faults_.backlash_deg / 2, motor_deg_ + faults_.backlash_deg / 2);
  }
  double rad() const { return out_deg_ * kDeg; }

 private:
  struct Late {
    double at_s, deg;
  };
  ServoFaults faults_;
  double motor_deg_, out_deg_, target_deg_, speed_deg_s_ = 0, pulse_at_s_ = 0;
  std::optional<double> command_deg_;
  bool runs_ = false;
  std::deque<Late> late_;
};

struct LoopSetup {
  AimOptions options;
  ServoFaults servo;
  HeadAngles start;              // of the head, which the controller knows
  double camera_delay_s = 0.02;  // middle of the exposure to the step
  double rate_hz = 35;
  double noise_px = 0.3, distance_noise = 0.005;
  double dropped = 0;  // part of the frames that never come
  double invalid = 0;  // part of the frames that show nothing
  double duration_s = 3;
  std::uint64_t seed = 1;
  /// Of the robot's body at a time: x, y [m] and heading [rad].
  std::function<Eigen::Vector3d(double t_s)> robot = [](double) { return Eigen::Vector3d(0, 0, 0); };
  std::vector<Eigen::Vector3d> landmarks_m{{2, 0, 0}};  // in the world, numbered from 0
  std::function<bool(double t_s)> hidden = [](double) { return false; };
  std::function<AimOrder(double t_s)> order = [](double) { return AimOrder{}; };
  std::function<bool(double t_s)> inhibited = [](double) { return false; };
};

/// One exposure, or one step.
struct LoopRow {
  double t_s = 0;
  double error_deg = 0;  // of landmark 0 from the middle of the picture, in truth
  bool visible = false;  // it was in the picture
  HeadAngles head, command;
  AimState state = AimState::kNone;
  bool at_goal = false;
};

/// Something that moves a head by what frames show; not asked when the head is inhibited.
class Controller {
 public:
  virtual ~Controller() = default;
  virtual AimStep step(MonoTime now, const HeadState& head, const AimFrame& frame, const AimOrder& order,
                       bool inhibited) = 0;
};

class Servoing final : public Controller {
 public:
  explicit Servoing(const LoopSetup& setup) : unit(CameraModel{}, setup.options, setup.start) {}
  AimStep step(MonoTime now, const HeadState& head, const AimFrame& frame, const AimOrder& order,
               bool inhibited) override {
    return unit.step(now, head, frame, order, inhibited);
  }
  Aimer unit;
};

class ClosedLoop {
 public:
  explicit ClosedLoop(const LoopSetup& setup)
      : setup_(setup),
        random_(setup.seed),
        pan_(setup.servo, setup.start.pan_rad),
        tilt_(setup.servo, setup.start.tilt_rad) {}

  /// \return  one row a millisecond
  std::vector<LoopRow> run(Controller& controller) {
    std::vector<LoopRow> rows;
    HeadState head;
    head.angles = setup_.start;
    double exposed_s = 0, next_step_s = 0;
    LoopRow row;
    row.command = setup_.start;
    for (int ms = 0; ms < setup_.duration_s * 1000; ++ms) {
      row.t_s = ms * 1e-3;
      pan_.step(row.t_s);
      tilt_.step(row.t_s);
      row.head = {pan_.rad(), tilt_.rad()};
      look(row);
      if (row.t_s >= exposed_s) {
        exposed_s += 1 / setup_.rate_hz;
        if (random_.uniform(0, 1) >= setup_.dropped) expose(row);
      }
      const bool is_frame = !on_their_way_.empty() && on_their_way_.front().at_s <= row.t_s;
      if (is_frame || row.t_s >= next_step_s) {
        std::vector<AimSight> sights;
        if (is_frame) sights = on_their_way_.front().sights, on_their_way_.pop_front();
        const AimStep step =
            controller.step(time(row.t_s), head, {is_frame, sights}, setup_.order(row.t_s), setup_.inhibited(row.t_s));
        next_step_s = row.t_s + std::chrono::duration<double>(Sweep::kTick).count() - 1e-9;
        row.command = step.command, row.state = step.state, row.at_goal = step.at_goal;
        head.angles = step.command;
        pan_.command(step.command.pan_rad);
        tilt_.command(step.command.tilt_rad);
      }
      rows.push_back(row);
    }
    return rows;
  }
  static MonoTime time(double t_s) {
    return MonoTime(std::chrono::nanoseconds(100'000'000'000 + std::llround(t_s * 1e9)));
  }

 private:
  struct Late {
    double at_s;
    std::vector<AimSight> sights;
  };
  Eigen::Vector3d seen(const LoopRow& row, const Eigen::Vector3d& landmark_m) const {
    const Eigen::Vector3d robot = setup_.robot(row.t_s);
    const Eigen::Vector3d body = exp_so3({0, 0, -robot.z()}) * (landmark_m - Eigen::Vector3d(robot.x(), robot.y(), 0));
    return camera_on_body(setup_.options.body, row.head).T_body_camera.inverse() * body;
  }
  bool is_visible(const Eigen::Vector3d& p) const {
    if (!(p.z() > 0.1)) return false;
    const Eigen::Vector2d px = camera_.pixel_from_normalised(p.hnormalized());
    // The whole ring of 0.1 m must be in the picture.
    const double margin = camera_.fx_px * 0.1 / p.z();
    return px.x() > margin && px.y() > margin && px.x() < camera_.width_px - margin &&
           px.y() < camera_.height_px - margin;
  }
  void look(LoopRow& row) const {
    const Eigen::Vector3d p = seen(row, setup_.landmarks_m.front());
    row.error_deg = std::atan2(p.head<2>().norm(), p.z()) / kDeg;
    row.visible = is_visible(p) && !setup_.hidden(row.t_s);
  }
  void expose(const LoopRow& row) {
    Late late{row.t_s + setup_.camera_delay_s, {}};
    const bool shows = random_.uniform(0, 1) >= setup_.invalid && !setup_.hidden(row.t_s);
    for (std::size_t i = 0; i < setup_.landmarks_m.size() && shows; ++i) {
      Eigen::Vector3d p = seen(row, setup_.landmarks_m[i]);
      if (!is_visible(p)) continue;
      const double sigma = setup_.noise_px / camera_.fx_px * p.z();
      p += Eigen::Vector3d(sigma * random_.normal(), sigma * random_.normal(), 0);
      p *= 1 + setup_.distance_noise * random_.normal();
      late.sights.push_back({static_cast<std::uint16_t>(i), time(row.t_s), p});
    }
    on_their_way_.push_back(late);
  }

  const LoopSetup setup_;
  Random random_;
  Servo pan_, tilt_;
  CameraModel camera_;
  std::deque<Late> on_their_way_;
};

}  // namespace ninedot::test
