#pragma once
/// `solver = "full"`: near the maximum-likelihood pose, from the grey levels along all dot outlines.
#include <memory>

#include "base/result.h"
#include "detect/observation.h"
#include "geometry/camera_model.h"
#include "image/image_view.h"
#include "pose/estimate.h"

namespace ninedot {

/// Memory: everything is allocated by the constructor. Threads: one caller.
class FullSolver {
 public:
  FullSolver(const CameraModel& camera, const LandmarkGeometry& landmark);
  ~FullSolver();
  FullSolver(const FullSolver&) = delete;
  FullSolver& operator=(const FullSolver&) = delete;

  /// \param luma  the picture that `seen` was found in
  /// \param previous  the pose of the frame before, for continuity between the two planar solutions; may be null
  /// \error kPoseDegenerate: what is visible does not determine a pose
  Result<PoseEstimate> solve(const ImageView& luma, const LandmarkObservation& seen,
                             const Transform<frame::Landmark, frame::Camera>* previous) noexcept;

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace ninedot
