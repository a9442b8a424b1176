#pragma once
/// `solver = "full"`: near the maximum-likelihood pose, from the grey levels along all dot outlines.
#include <memory>
#include <optional>

#include "base/result.h"
#include "detect/observation.h"
#include "geometry/camera_model.h"
#include "image/image_view.h"
#include "pose/estimate.h"
#include "pose/pose_expectation.h"

namespace ninedot {

/// What a track knows of the landmark before its next picture. The solver remembers nothing by itself.
struct PosePrior {
  CameraFromLandmark T_camera_landmark;  ///< in the frame before
  OutlineState outlines;         ///< of the frame before: blur and offset are the camera's more than the frame's
  double warp_px = 0;            ///< the sheet's, likewise
  bool side_is_settled = false;  ///< the track has told the two planar solutions apart
};

struct FullSolverOptions {
  /// Of the position, as a share of the distance: who knows no more of one landmark has no pose. [1]
  double most_sigma = 0.1;
  /// What a colour camera's pattern and its interpolation leave at each dot: limits what tells two planar solutions
  /// apart (pose/mirror_image.h).
  double pattern_px = 0;
  bool regards_walls = false;  ///< OutlinePixels::regards_walls
};

/// Memory: everything is allocated by the constructor; it is scratch, and no answer depends on the call before.
/// Threads: one caller.
class FullSolver {
 public:
  FullSolver(const CameraModel& camera, const LandmarkGeometry& landmark, const FullSolverOptions& options = {});
  ~FullSolver();
  FullSolver(const FullSolver&) = delete;
  FullSolver& operator=(const FullSolver&) = delete;

  /// \param luma  the picture that `seen` was found in
  /// \param prior  null: there was no pose in the frame before
  /// \param pixels  how many it may fit (WorkBudget); fewer afterwards. Used up, there is no answer.
  /// \param motion  of the sheet while the rows are exposed: the pose is that of its middle row
  /// \error kPoseDegenerate: what is visible does not determine a pose. kNoLandmark: the outlines are no landmark's.
  Result<PoseCandidates> solve(const ImageView& luma, const LandmarkObservation& seen, const PosePrior* prior,
                               int& pixels, const SheetMotion& motion = {}) noexcept;
  /// What the last solve() came to where it said kNoLandmark: for showing people what was looked at.
  const std::optional<PoseCandidates>& refused() const noexcept { return refused_; }

  /// The pose without a detector: from the outlines where they are expected. It takes about half the time, and the
  /// answer is that of `solve`. \param expected  what is found and not like that is not the landmark
  /// \error kNoLandmark: it is not quite there, edges of light seem to cross most of its dots, or there were no pixels
  /// left to refine an open mirror image with: detect it
  Result<PoseCandidates> follow(const ImageView& luma, const PoseExpectation& expected, const PosePrior& prior,
                                int& pixels, const SheetMotion& motion = {}) noexcept;

  /// The pose of another solver, once its outlines have been moved to where they fit the picture best.
  /// \error kPoseDegenerate: they lead to no pose
  Result<PoseCandidate> examine(const ImageView& luma, const CameraFromLandmark& T_camera_landmark, int& pixels,
                                const SheetMotion& motion = {}) noexcept;

 private:
  struct Workspace;
  std::unique_ptr<Workspace> workspace_;
  std::optional<PoseCandidates> refused_;
};

}  // namespace ninedot
