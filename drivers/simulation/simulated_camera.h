#pragma once
/// A camera on a head on a moving robot, as a FrameSource: what it would see, exposure by exposure.
#include <functional>
#include <memory>
#include <vector>

#include "drivers/simulation/robot_path.h"
#include "drivers/simulation/servo_motion.h"
#include "drivers/simulation/sheet_renderer.h"
#include "drivers/simulation/simulated_head.h"
#include "drivers/simulation/simulation_clock.h"
#include "ports/frame_source.h"

namespace ninedot {

/// A time during which everything is covered.
struct HiddenTime {
  double from_s = 0, to_s = 0;
};

struct SimulationOptions {
  CameraModel camera;
  std::vector<HungSheet> sheets;
  std::vector<WayPoint> robot;  ///< at least one (contract)
  std::vector<HiddenTime> hidden;
  HeadMount mount;
  ServoDynamics pan, tilt;
  HeadAngles start;  ///< where the head stands before its first command
  /// Where a command truly sends the head; empty: where it says. Must neither throw nor allocate.
  std::function<HeadAngles(const HeadAngles& told)> true_angles;
  double rate_hz = 35;
  double duration_s = 10;
  bool loop = false;                        ///< the robot begins its path anew after `duration_s`
  std::chrono::nanoseconds camera_delay{};  ///< from mid-exposure to the frame's arrival
  RendererOptions renderer;
};

/// What was truly the case in the middle of a frame's exposure.
struct SimulationTruth {
  double t_s = 0;  ///< since the start of the path
  WayPoint body;
  HeadAngles head;                                     ///< where the camera points
  Eigen::Vector3d camera_m = Eigen::Vector3d::Zero();  ///< its optical centre, frame world
  bool visible = false;         ///< the middle of the main landmark's P9 is in the picture, and nothing is covered
  double centre_error_rad = 0;  ///< between the optical axis and the main landmark's P9; 0 without a landmark
};

/// Each frame is exposed at its time, of where robot and head are then, and arrives `camera_delay` later, or when its
/// exposure has ended. Frames that were not fetched before the next one arrived are lost, and counted.
/// The main landmark is the one nearest to the camera, of those that face it.
/// Memory: everything is allocated by the constructor. Threads: one caller; it works in `next`, about a millisecond a
/// frame. One lease at a time (contract).
class SimulatedCamera final : public FrameSource, private FrameOwner {
 public:
  /// The first exposure is at the first call of `next`. \param line  commands to its head \param clock  must outlive
  /// this
  SimulatedCamera(const SimulationOptions& options, std::shared_ptr<HeadLine> line, SimulationClock& clock);

  Result<FrameLease> next(MonoTime deadline) noexcept override;

  /// Of the frame that was lent last.
  const SimulationTruth& truth() const noexcept { return truth_; }

 private:
  void give_back(std::uint32_t buffer) noexcept override;
  MonoTime exposed_at(std::uint64_t frame) const noexcept;
  std::uint64_t newest_arrived() const noexcept;
  double path_time_s(MonoTime at) const noexcept;
  void hear_commands() noexcept;
  Eigen::Isometry3d camera_at(MonoTime at, SimulationTruth* truth) noexcept;
  void note_landmark(const Eigen::Isometry3d& T_world_camera) noexcept;
  bool is_hidden(double t_s) const noexcept;

  const SimulationOptions options_;
  const std::shared_ptr<HeadLine> line_;
  SimulationClock& clock_;
  SheetRenderer renderer_;
  const std::chrono::nanoseconds half_, delay_;  // of the exposure of all rows; from its middle to the arrival
  MonoTime started_at_{};
  ServoMotion pan_, tilt_;
  std::uint64_t commands_heard_ = 0;
  std::uint64_t frame_ = 0;  // the next one
  bool is_lent_ = false, has_started_ = false;
  SimulationTruth truth_;
};

}  // namespace ninedot
