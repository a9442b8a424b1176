#pragma once
/// Pictures of a camera that turns while they are exposed: how it turns, by a track or by the pictures themselves, and
/// what they would look like if it stood, for finding landmarks whose dots run into each other.
#include <optional>

#include "geometry/camera_model.h"
#include "geometry/sheet_motion.h"
#include "image/frame.h"
#include "image/motion_unblur.h"
#include "pipeline/camera_twist.h"
#include "pipeline/picture_exposure.h"
#include "pipeline/visual_gyro.h"
#include "pose/outline_state.h"

namespace ninedot {

/// Memory: everything is allocated by the constructor. Threads: one caller.
class SmearedView {
 public:
  explicit SmearedView(const CameraModel& camera) : gyro_(camera), unblur_(camera.width_px, camera.height_px) {}

  /// A new picture. \param tracked  how the camera turns, where a track knows; the pictures are asked elsewhere, and
  /// believed where they are smeared
  void begin(const Frame& frame, const CameraModel& camera, const std::optional<CameraTwist>& tracked) noexcept;

  /// How the camera moves in it; none: nobody knows.
  const std::optional<CameraTwist>& twist() const noexcept { return twist_; }
  /// How long it is exposed: as it says, or as landmarks before it have shown; 0: nobody knows. [s]
  double exposure_s() const noexcept { return exposure_.seconds(); }
  /// Dots of a distant ring run into each other.
  bool is_smeared() const noexcept { return is_smeared_; }
  /// The picture as if it were not. \return  valid until the next call
  ImageView unblurred(const ImageView& luma, const CameraModel& camera) noexcept;

  /// A landmark in it says how long it was exposed, where the picture does not. \param motion  of its sheet
  void note(const SheetMotion& motion, const OutlineState& outlines, const CameraModel& camera) noexcept {
    exposure_.note(motion, outlines, camera);
  }

 private:
  double line_px(const CameraTwist& twist, const CameraModel& camera) const noexcept;

  VisualGyro gyro_;
  MotionUnblur unblur_;
  PictureExposure exposure_;
  std::optional<CameraTwist> twist_;
  bool is_smeared_ = false;
};

}  // namespace ninedot
