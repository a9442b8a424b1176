#pragma once
/// How a camera turns, as its pictures tell that show nothing known yet: by what they have moved by as a whole. Where
/// it is and goes nobody knows then, and walls that are near move otherwise than walls that are far.
#include <optional>

#include "geometry/camera_model.h"
#include "image/frame.h"
#include "image/picture_shift.h"
#include "pipeline/camera_twist.h"

namespace ninedot {

/// Memory: everything is allocated by the constructor. Threads: one caller.
class VisualGyro {
 public:
  explicit VisualGyro(const CameraModel& camera) : shift_(camera.width_px, camera.height_px) {}

  /// The next picture. \return  how the camera turns while it is exposed, gaining speed as from the picture before
  /// that; none: the last two pictures do not tell
  std::optional<CameraTwist> turn(const Frame& frame, const CameraModel& camera) noexcept;

 private:
  PictureShift shift_;
  MonoTime at_{};
  std::optional<Eigen::Vector3d> rate_rad_s_;  ///< between the last two pictures
};

}  // namespace ninedot
