#pragma once
/// The aiming step: turns the head so that the landmark comes to the middle of the picture.
///
/// This is the plain step that a visual-servoing controller replaces later: what it is told and what it answers stay.
#include <Eigen/Geometry>
#include <cstdint>

#include "aim/head_track.h"
#include "base/head_angles.h"
#include "base/mono_time.h"
#include "geometry/camera_model.h"

namespace ninedot {

struct AimAxis {
  double min_rad = -1, max_rad = 1;  ///< min < max (contract)
  double slew_rad_per_s = 1;         ///< > 0 (contract)
};

struct AimOptions {
  AimAxis pan, tilt;
  HeadAngles neutral;          ///< where the head stands at the start
  double dead_band_rad = 0.0;  ///< per axis: a smaller deviation is no reason to move
  double gain = 0.5;           ///< part of the deviation that one step takes away, (0, 1]
};

/// What the head is to do. Trivially copyable: it comes to the frame loop from other threads.
struct AimOrder {
  bool follow = true;    ///< keep the landmark in the middle; else go to `set_point` and stay there
  HeadAngles set_point;  ///< saturates at the limits
  /// Another one for each order; 0: what the head does from the start on, nobody waits for it.
  std::uint32_t number = 0;
};

/// The landmark in one frame.
struct AimSight {
  bool valid = false;  ///< false: nothing to follow, the head stays
  MonoTime exposed_at{};
  Eigen::Vector3d landmark_camera_m{0, 0, 1};  ///< the middle of P9, frame camera
};

struct AimStep {
  HeadAngles command;    ///< within the limits
  bool limited = false;  ///< the goal lies beyond the limits
  bool at_goal = false;  ///< the command is the goal itself, or as near as the limits allow
};

/// The head's angles at which the direction `target_camera`, seen while the head stood at `head`, coincides with the
/// camera's own direction `centre_camera`. Exact for a head whose two axes meet in the optical centre, or for a target
/// that is far compared with their distance.
/// \param target_camera, centre_camera  frame camera, any length > 0, centre_camera within 90 deg of the optical axis
/// Memory: none. Threads: pure.
HeadAngles angles_towards(const Eigen::Vector3d& target_camera, const Eigen::Vector3d& centre_camera,
                          const HeadAngles& head) noexcept;

/// Memory: inside. Threads: one caller, the frame loop, for all methods; nothing waits, all are real-time safe. What
/// others want of the head reaches it as the AimOrder of a step.
class Aimer {
 public:
  /// \param head  where the head stands at the start, and has always stood
  Aimer(const CameraModel& camera, const AimOptions& options, const HeadAngles& head = {}) noexcept;

  /// To be called once per frame, also without a landmark.
  /// \param head  where the head stands now. It is remembered: a frame was exposed some time ago, and counts from where
  ///              the head stood then.
  /// \param inhibited  nothing may move: the command is where the head stands
  AimStep step(MonoTime now, const HeadAngles& head, const AimSight& sight, const AimOrder& order,
               bool inhibited) noexcept;

  /// Where the head has stood, as far as step() was told.
  const HeadTrack& track() const noexcept { return track_; }

 private:
  AimOptions options_;
  Eigen::Vector3d centre_camera_;  // the direction of the picture's middle
  HeadAngles command_;
  MonoTime stepped_at_{};
  HeadTrack track_;
};

}  // namespace ninedot
