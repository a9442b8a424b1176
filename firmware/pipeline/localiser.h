#pragma once
/// One frame's path: picture -> dots -> landmark -> pose with its uncertainty -> report. The whole path is in
/// `process`.
#include <optional>

#include "detect/detector.h"
#include "pipeline/frame_processor.h"
#include "pose/ellipse_solver.h"
#include "pose/full_solver.h"

namespace ninedot {

struct LocaliserOptions {
  LandmarkGeometry landmark{};
  DetectorOptions detector{};
  Solver solver = Solver::kFull;
  EllipseCalibration ellipse{};
  bool tracking = true;        ///< look where the landmark was before searching the whole picture
  double max_ambiguity = 0.7;  ///< above: Report::ambiguous
  std::uint16_t landmark_id = 0;
  Transform<frame::World, frame::Landmark> T_world_landmark{};
  bool calibrated = true;
};

/// How much to trust a pose, 0..1000: 1000 * precision * visible * unique, rounded, where
///   precision = 1 / (1 + (sigma / (0.005 D))^2): a half at a 1-sigma of 0.5 % of the distance D, sigma over all axes;
///   visible = dots_used / 9;
///   unique = 1 - ambiguity / 2: a half when the other planar solution fits as well.
std::uint16_t pose_quality(const PoseEstimate& pose) noexcept;

/// Whether a pose may be published: every number finite, every variance above zero. A covariance of zero would claim a
/// certainty that no camera has.
bool is_publishable(const PoseEstimate& pose) noexcept;

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
  const LandmarkObservation* last_observation() const noexcept { return found_last_ ? &seen_ : nullptr; }

 private:
  /// Where the landmark was in the frame before, or where its motion has taken it since.
  Result<PoseEstimate> follow(const ImageView& luma, MonoTime exposed_at) noexcept;
  /// Remembers the motion since the frame before, and how well it was foretold. \param pose  of the new frame
  void note_motion(const Result<PoseEstimate>& pose, MonoTime exposed_at) noexcept;
  /// The sheet before the camera, if it goes on as between the last two frames.
  CameraFromLandmark expected_at(MonoTime time) const noexcept;
  /// Everywhere.
  Result<PoseEstimate> search(const ImageView& luma) noexcept;
  Result<PoseEstimate> solve(const ImageView& luma, const PoseEstimate* previous) noexcept;
  void fill_pose(const PoseEstimate& pose) noexcept;

  /// Per second, in the camera frame.
  struct Motion {
    Eigen::Vector3d rotation_rad, translation_m;
  };

  LocaliserOptions options_;
  double focal_px_;
  Detector detector_;
  FullSolver full_;
  EllipseSolver ellipse_;
  Fix fix_;
  LandmarkObservation seen_{};
  PoseEstimate pose_{};
  MonoTime pose_at_{};
  std::optional<Motion> motion_;  // between the last two frames, if both had a pose
  double surprise_px_ = 0;        // how far the landmark was from where it was expected
  bool found_last_ = false;       // seen_ is of the frame before
  bool solved_last_ = false;      // pose_ is of the frame before
};

}  // namespace ninedot
