#pragma once
/// What an integrator sets about aiming: [pan_tilt] and [body] of the configuration.
#include <chrono>
#include <cstdint>

#include "base/head_angles.h"
#include "geometry/body.h"

namespace ninedot {

struct AimAxis {
  double min_rad = -1, max_rad = 1;       ///< min < max (contract)
  double slew_rad_per_s = 1;              ///< > 0 (contract)
  double acceleration_rad_per_s2 = 1000;  ///< > 0 (contract)
};

/// Of several landmarks in the picture, the one that is kept in the middle.
enum class LandmarkChoice : std::uint8_t {
  kHandOver,  ///< the one before, until another is nearer by a margin for some time
  kNearest,   ///< the nearest; of two equally far the one before
  kReported,  ///< the one whose pose is reported
  kById,      ///< one only
};

struct AimOptions {
  AimAxis pan, tilt;
  HeadAngles neutral;                     ///< where the head waits until it has seen a landmark
  HeadAngles park;                        ///< where it parks
  double dead_band_rad = 0.0;             ///< per axis: a smaller deviation is no reason to leave a place
  double gain = 0.5;                      ///< part of a sight's deviation that a frame takes away at 35 Hz [1], (0, 1]
  std::chrono::nanoseconds head_delay{};  ///< from a command until the head stands there
  std::chrono::nanoseconds coast = std::chrono::seconds(1);  ///< so long a landmark out of sight is followed on
  std::chrono::nanoseconds park_after{};                     ///< without a sight; 0: never by itself
  bool search = true;                                        ///< sweep for a landmark that was lost
  bool search_at_start = false;                              ///< also for one that has not been seen yet
  double search_rad_per_s = 0.8;  ///< at most so fast, for the sake of sharp pictures; > 0 (contract)
  LandmarkChoice landmark = LandmarkChoice::kHandOver;
  std::uint16_t landmark_id = 0;  ///< of kById
  double hand_over_margin = 0.2;  ///< of kHandOver: nearer by this part of the distance [1], [0, 1)
  BodyGeometry body{};            ///< the head's axes and the camera on them
};

}  // namespace ninedot
