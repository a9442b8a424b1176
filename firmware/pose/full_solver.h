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
  /// \param previous  what the frame before gave, when the landmark was followed from there; else null. Tells the two
  ///        planar solutions apart where the picture can't; one that the track has excluded is not refined again, and
  ///        the ambiguity stays as it was.
  /// \error kPoseDegenerate: what is visible does not determine a pose
  Result<PoseEstimate> solve(const ImageView& luma, const LandmarkObservation& seen,
                             const PoseEstimate* previous) noexcept;

  /// The pose without a detector: from the outlines where they are expected, as long as every dot of the frame before
  /// is there. It takes about half the time, and the answer is that of `solve`. \param expected  the sheet before the
  /// camera in this picture, outlines within about half a pixel \param previous  of the frame before, by this solver
  /// \param seen  on success becomes what a detector would have handed over
  /// \error kNoLandmark: it is not quite there, or not all of it, or its mirror image has to be looked into: detect it
  Result<PoseEstimate> follow(const ImageView& luma, const CameraFromLandmark& expected, const PoseEstimate& previous,
                              LandmarkObservation& seen) noexcept;

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
};

}  // namespace ninedot
