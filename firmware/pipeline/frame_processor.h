#pragma once
/// What the frame loop does with each frame.
#include <array>
#include <chrono>
#include <cstdint>

#include "image/frame.h"
#include "pose/estimate.h"
#include "report/report.h"

namespace ninedot {

/// What one frame says of where the camera is. Says nothing of the frames before it.
struct Fix {
  Reason reason = Reason::kNoLandmark;  ///< kNone: all below is valid; else only `found`, `tracked`, `process_time`
  bool found = false;                   ///< the frame shows a landmark
  bool tracked = false;                 ///< it was where it was expected
  bool calibrated = false;              ///< the camera's calibration was loaded
  Solver solver = Solver::kFull;
  std::uint16_t landmark_id = 0;
  PoseEstimate pose;                                      ///< of the camera in the frame of that landmark
  Transform<frame::World, frame::Camera> T_world_camera;  ///< by the map
  std::array<double, 6> sigma_world{};                    ///< 1-sigma: x y z [m], about the world's x y z [rad]
  bool ambiguous = false;                                 ///< above the configured limit
  std::uint16_t quality = 0;                              ///< 0..1000, see pose_quality
  std::chrono::nanoseconds process_time{};
  WorkCounts work;  ///< of all frames since the start, whatever `reason` says
};

class FrameProcessor {
 public:
  virtual ~FrameProcessor() = default;
  /// \return  valid until the next call. Memory: none. Threads: one caller.
  virtual const Fix& process(const Frame& frame) noexcept = 0;
};

}  // namespace ninedot
