#pragma once
/// How long the rows of a picture are exposed.
#include "geometry/camera_model.h"
#include "geometry/sheet_motion.h"
#include "image/frame.h"
#include "pipeline/exposure_belief.h"
#include "pose/outline_state.h"

namespace ninedot {

/// Memory: none. Threads: one caller.
class PictureExposure {
 public:
  /// A new picture.
  void begin(const Frame& frame) noexcept;
  /// As it says, or as landmarks before it have shown; 0: nobody knows. [s]
  double seconds() const noexcept { return seconds_; }
  /// A landmark in it says how long it was exposed, where the picture does not. \param motion  of its sheet
  void note(const SheetMotion& motion, const OutlineState& outlines, const CameraModel& camera) noexcept;

 private:
  ExposureBelief belief_;
  double seconds_ = 0;
  bool is_told_ = false;  // by the picture
};

}  // namespace ninedot
