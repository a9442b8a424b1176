#pragma once
/// The visual-servoing controller: turns the head so that the landmark comes to the middle of the picture and stays
/// there, and looks for it where it is lost. How it works, and with what margins: docs/pan-tilt.md.
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>

#include "aim/aim_options.h"
#include "aim/aim_transitions.h"
#include "aim/axis_ramp.h"
#include "aim/head_kinematics.h"
#include "aim/head_track.h"
#include "aim/landmark_chooser.h"
#include "aim/standing.h"
#include "aim/sweep.h"
#include "aim/target_motion.h"
#include "base/head_angles.h"
#include "base/mono_time.h"
#include "geometry/camera_model.h"
#include "ports/pan_tilt.h"

namespace ninedot {

/// What the head is to do. Trivially copyable: it comes to the head's thread from others.
struct AimOrder {
  bool follow = true;    ///< keep the landmark in the middle; else go to `set_point` and stay there
  HeadAngles set_point;  ///< saturates at the limits
  /// Another one for each order; 0: what the head does from the start on, nobody waits for it.
  std::uint32_t number = 0;
  bool park = false;  ///< go to the parking place and stay there, whatever `follow` says

  bool operator==(const AimOrder&) const = default;
};

/// What the newest frame shows.
struct AimFrame {
  bool is_new = false;                 ///< false: there has been no frame since the step before
  std::span<const AimSight> sights{};  ///< the landmarks that may be acted on, the one that is reported first
};

struct AimStep {
  AimState state = AimState::kHold;
  HeadAngles command;    ///< within the limits
  bool limited = false;  ///< the goal lies beyond the limits
  bool at_goal = false;  ///< the command is the goal itself, or as near as the limits allow
};

/// Memory: inside. Threads: one caller for all methods; nothing waits, all are real-time safe, and take a bounded time:
/// of the order of 10 us. What others want of the head reaches it as the AimOrder of a step.
class Aimer {
 public:
  /// Without a frame for so long the landmark counts as missed.
  static constexpr std::chrono::milliseconds kNoFrame{300};

  /// \param head  where the head stands at the start, and has always stood: from there it sets out
  Aimer(const CameraModel& camera, const AimOptions& options, const HeadAngles& head = {}) noexcept;

  /// To be called once per frame, also without a landmark, and between frames as often as the head takes commands.
  /// \param head  its state now. Its angles are remembered: a frame was exposed some time ago, and counts from where
  ///              the head stood then. An absent head is taken to stand where it says, until it is there.
  /// \param inhibited  nothing may move: the command is where the head stands
  AimStep step(MonoTime now, const HeadState& head, const AimFrame& frame, const AimOrder& order,
               bool inhibited) noexcept;

  /// Where the head has stood, as far as step() was told.
  const HeadTrack& track() const noexcept { return track_; }
  AimState state() const noexcept { return state_; }
  const Sweep& sweep() const noexcept { return sweep_; }

 private:
  struct Goal {
    AxisGoal pan, tilt;
    bool limited = false;
  };

  double trust_at(MonoTime exposed_at) const noexcept;
  void take_sight(MonoTime now, const AimSight& sight) noexcept;
  AimEvents events(MonoTime now, bool held, bool saw, const AimFrame& frame, const AimOrder& order) const noexcept;
  void enter(AimState state) noexcept;
  Goal goal_of(MonoTime now, const AimOrder& order) noexcept;
  Goal followed(MonoTime now) noexcept;
  Goal swept() noexcept;
  Goal still_at(const HeadAngles& angles) const noexcept;
  bool is_standing_at(const HeadAngles& angles) const noexcept;
  HeadAngles command() const noexcept { return {pan_.angle_rad(), tilt_.angle_rad()}; }
  HeadAngles braked() const noexcept;

  const AimOptions options_;
  const HeadKinematics kinematics_;
  LandmarkChooser chooser_;
  Sweep sweep_;
  HeadTrack track_;
  AxisRamp pan_, tilt_;
  Standing pan_standing_, tilt_standing_;
  TargetMotion motion_;

  AimState state_ = AimState::kHold;
  AimOrder order_;
  HeadAngles stay_;  // where it holds without an order
  MonoTime stepped_at_{}, active_at_{};
  std::optional<MonoTime> saw_at_;  // when the newest sight of the followed landmark came
  std::uint16_t followed_id_ = 0;
  double off_centre_rad_ = 0;  // in that sight
};

}  // namespace ninedot
