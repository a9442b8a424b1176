#pragma once
/// A fit that took its sheet's motion for another one than it was, put right: each row that a rolling shutter exposed
/// later or earlier than the middle one moves by the difference.
#include "geometry/camera_model.h"
#include "geometry/sheet_motion.h"
#include "pose/estimate.h"

namespace ninedot {

/// The dots' rays, each by its own row, and the pose as far as they take it along; all else stays as it was fitted.
/// Memory: none. Threads: pure.
/// \param taken  what the fit took; its rows count \param motion  what it was
void retake_rows(PoseCandidate& fitted, const SheetMotion& taken, const SheetMotion& motion,
                 const LandmarkGeometry& landmark, const CameraModel& camera) noexcept;

}  // namespace ninedot
