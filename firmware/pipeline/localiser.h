#pragma once
/// One frame's path: picture -> dots -> landmark -> pose with its uncertainty -> fix. The whole path is in `process`.
#include "detect/detector.h"
#include "image/noise.h"
#include "pipeline/frame_processor.h"
#include "pipeline/verdict.h"
#include "pose/ellipse_solver.h"
#include "pose/full_solver.h"
#include "track/track.h"
#include "world/landmark_map.h"

namespace ninedot {

struct LocaliserOptions {
  LandmarkGeometry landmark{};
  DetectorOptions detector{};
  Solver solver = Solver::kFull;
  EllipseCalibration ellipse{};
  bool tracking = true;  ///< look where the landmark was before searching the whole picture
  TrustLimits trust{};   ///< what is beyond them is found, but not valid
  WorkBudget budget{};   ///< what one frame may cost
  LandmarkMap map{};     ///< one landmark as yet: the first is the one that is seen
  bool calibrated = true;
};

/// How much to trust a pose, 0..1000: 1000 * precision * visible * unique, rounded, where
///   precision = 1 / (1 + (sigma / (0.005 D))^2): a half at a 1-sigma of 0.5 % of the distance D, sigma over all axes;
///   visible = dots_used / 9;
///   unique = 1 - ambiguity / 2: a half when the other planar solution fits as well.
std::uint16_t pose_quality(const PoseEstimate& pose) noexcept;

/// 1-sigmas of a pose along the world's axes: x y z [m], rotation about the world's x y z [rad].
std::array<double, 6> world_sigmas(const PoseEstimate& pose,
                                   const Transform<frame::World, frame::Landmark>& T_world_landmark) noexcept;

/// Memory: everything is allocated by the constructor. Threads: one caller.
class Localiser final : public FrameProcessor {
 public:
  Localiser(const CameraModel& camera, const LocaliserOptions& options);

  const Fix& process(const Frame& frame) noexcept override;

  /// The last landmark found, for overlays; null when the last frame showed none. Where its outlines alone were
  /// followed it says so (LandmarkObservation::from_pose).
  const LandmarkObservation* last_observation() const noexcept {
    return track_.has_sighting() ? &track_.sighting() : nullptr;
  }

 private:
  /// What a way to the pose has found, chosen and judged to fit the picture. None of them: the error of the last one
  /// that saw something.
  Result<std::size_t> follow_outlines(const Frame& frame) noexcept;
  Result<std::size_t> detect_near_track(const Frame& frame) noexcept;
  Result<std::size_t> search(const Frame& frame) noexcept;
  Result<std::size_t> solve_guess(const Frame& frame, LandmarkObservation seen) noexcept;
  Result<std::size_t> solve(const Frame& frame, const LandmarkObservation& seen, const PosePrior* prior) noexcept;
  void add_fix(std::size_t chosen, bool fits) noexcept;

  const LocaliserOptions options_;
  CameraModel camera_;
  Detector detector_;
  FullSolver full_;
  EllipseSolver ellipse_;
  Track track_;
  // What the frame before had no pixels left for: 0 nothing; else the search leaves out the likeliest guess and begins
  // with this one of the less likely.
  std::size_t next_guess_ = 0;
  std::uint32_t frames_cut_ = 0;
  // Of the frame under way.
  PictureNoise noise_;
  WorkBudget budget_;
  PoseCandidates candidates_;
  std::optional<PoseCandidates> misfit_;  // the first that looked like a landmark and does not fit the picture
  Fix fix_;
};

}  // namespace ninedot
