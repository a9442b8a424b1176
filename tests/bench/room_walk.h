#pragma once
/// A robot that goes along a wall of coded landmarks and looks ahead and to the side, turning its head.
#include <Eigen/Core>
#include <cstddef>
#include <string>
#include <vector>

#include "tests/support/random.h"
#include "tests/support/room_renderer.h"

namespace ninedot::bench {

/// One row of a rooms' table.
struct RoomCondition {
  std::string label;
  double plot_x = 0;      ///< the label's number, for the plot
  double distance_m = 2;  ///< of the camera from the wall
  double noise_at_grey128_lsb = 2;
  double light_kelvin = 5000;  ///< the camera is balanced for 5000 K
  double speed_m_s = 1;        ///< 0: it stands, and the head too
  double exposure_s = 0.004;
  double readout_s = 0.016;  ///< of the rolling shutter, all rows; 0: global
  bool is_told = true;       ///< the configuration says so; else it says nothing of the shutter
};

/// A room, and the way through it. Threads: const is safe.
class RoomWalk {
 public:
  /// The same condition and random numbers, the same walk.
  RoomWalk(const RoomCondition& condition, test::Random random);

  const test::Room& room() const { return room_; }

  /// Optical centre and attitude in the world.
  test::CameraPose camera_at(double time_s) const;

  /// Sub-exposures of less than a pixel.
  test::Shutter shutter(const test::Lens& lens) const;

 private:
  test::Room room_;
  double speed_m_s_, exposure_s_, readout_s_, distance_m_;
  Eigen::Vector3d start_m_;
  double phase_rad_;  ///< of the head's swing
};

/// Indices of the landmarks that are wholly in the picture, not from behind, with ring dots of 2.2 px across or more.
std::vector<std::size_t> landmarks_shown(const test::Room& room, const test::Lens& lens,
                                         const test::CameraPose& camera);

}  // namespace ninedot::bench
