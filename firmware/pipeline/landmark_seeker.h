#pragma once
/// The ways from one picture to one landmark's pose: along its outlines where its track foretells them, by its dots
/// near there, or from dots that a search of the whole picture has found. What it needs of memory is scratch; what
/// lasts from frame to frame is each landmark's own track.
#include <chrono>
#include <optional>

#include "base/row_time.h"
#include "detect/detector.h"
#include "image/frame.h"
#include "image/noise.h"
#include "pipeline/camera_twist.h"
#include "pipeline/camera_unrest.h"
#include "pipeline/sighting_uncertainty.h"
#include "pose/ellipse_solver.h"
#include "pose/full_solver.h"
#include "pose/pose_of_outlines.h"
#include "report/report.h"
#include "track/track.h"

namespace ninedot {

struct SeekerOptions {
  LandmarkGeometry landmark{};
  DetectorOptions detector{};
  Solver solver = Solver::kFull;
  EllipseCalibration ellipse{};
  bool regards_walls = false;  ///< FullSolverOptions::regards_walls
  bool has_map = false;        ///< dots may have colours, and what a track foretells is known by its place in the map
};

/// Memory: everything is allocated by the constructor. Threads: one caller.
class LandmarkSeeker {
 public:
  LandmarkSeeker(const CameraModel& camera, const SeekerOptions& options);

  /// A new picture. \param budget  what it may cost
  /// \param rows  of the camera's shutter
  /// \param exposure_s  of each row; 0: unknown
  /// \param twist  how the camera moves, where that is known; none: a landmark's own track tells it
  void begin(const Frame& frame, const WorkBudget& budget, const RowTime& rows, double exposure_s = 0,
             const std::optional<CameraTwist>& twist = {}) noexcept;

  // What a way to the pose has found, chosen and judged to fit the picture, goes into the track and `candidates`.
  // Errors are those of the detector and of the solvers.

  /// \return  index of the chosen candidate [1]; likewise below
  /// \error kNoLandmark: the outlines can't be foretold well enough, or are not there
  Result<std::size_t> follow_outlines(Track& track) noexcept;
  /// \return  index [1]
  Result<std::size_t> detect_near_track(Track& track) noexcept;
  /// \param prior  null: nothing was known of it in the frame before \return  index [1]
  Result<std::size_t> solve(const LandmarkObservation& seen, const PosePrior* prior, Track& track,
                            bool is_foretold = false) noexcept;
  /// What looks like a landmark, though nothing has told yet where it is. What was tracked a moment ago keeps its
  /// numbers. Nothing is a black-and-white one whose dots are smaller than those of what has a whole ring in the same
  /// frame and is none: what is too small to be told from a landmark may be more of that. \return  index [1]
  Result<std::size_t> solve_guess(LandmarkObservation seen, Track& track) noexcept;

  /// Three dots that may be a landmark's (Detector::three_dots): the misfit, if there is no other one. No track knows
  /// of them.
  void show_three_dots(const LandmarkObservation& seen) noexcept;

  /// By its outlines alone, from where something else foretells it to two pixels: what is too small, too faint or too
  /// blurred to be seen as dots. \param T_camera_landmark  at the middle row \return  index [1]
  Result<std::size_t> look_at(const CameraFromLandmark& T_camera_landmark, Track& track) noexcept;

  /// Of the last way that led to a pose.
  const PoseCandidates& candidates() const noexcept { return candidates_; }
  /// Likewise: how its sheet moved while its rows were exposed. Its dots and its pose were taken to the middle row with
  /// that.
  const RowMotion& row_motion() const noexcept { return row_motion_; }
  /// Likewise: it would be one without a map as well, whose dots may have colours. Not asked of outlines that were
  /// followed.
  bool fits_black_and_white() const noexcept { return fits_black_and_white_; }
  /// What the search of the whole picture saw, where nothing came of it: the misfit before what did not get so far.
  FailedSearch failed_search() const noexcept;
  /// The first since `begin` that looked like a landmark and does not fit the picture, or of which too little is seen.
  const std::optional<PoseCandidates>& misfit() const noexcept { return misfit_; }
  /// Why it is one: kPoorFit, or kPoseDegenerate where three dots are all that is seen, and they do fit.
  Reason misfit_reason() const noexcept { return misfit_reason_; }

  const CameraModel& camera() const noexcept { return camera_; }
  Detector& detector() noexcept { return detector_; }
  WorkBudget& budget() noexcept { return budget_; }
  const PictureNoise& noise() const noexcept { return noise_; }

 private:
  /// How a sheet moves while its rows are exposed, and how well that is known.
  struct KnownMotion {
    SheetMotion sheet;
    double rate_sigma_rad_s = 0;  ///< of its direction's speed, 1-sigma, each axis
  };
  FitAllowance allowance(bool is_foretold) const noexcept;
  bool rows_differ() const noexcept { return rows_.mean_s != 0 || rows_.sigma_s > 0; }
  RowUncertainty uncertainty(const KnownMotion& motion, const Eigen::Vector3d& t_camera_m) const noexcept;
  std::optional<SheetMotion> first_motion(const Track& track, const Eigen::Vector3d& t_camera_m) const noexcept;
  KnownMotion motion_of(const Track& track, const Eigen::Vector3d& t_camera_m, bool is_seen_there) const noexcept;
  SheetMotion with_shutter(SheetMotion motion) const noexcept;
  double rate_sigma(const MeasuredMotion& measured) const noexcept;
  Result<std::size_t> take(const KnownMotion& taken, Track& track) noexcept;

  SeekerOptions options_;
  CameraModel camera_;
  Detector detector_;
  FullSolver full_;
  EllipseSolver ellipse_;
  // Of the frame under way.
  MonoTime frame_at_{};
  RowTime rows_;
  double exposure_s_ = 0;
  std::optional<CameraTwist> twist_;
  CameraUnrest unrest_;
  PictureNoise noise_;
  ImageView luma_;  ///< with what is known of its pattern
  WorkBudget budget_;
  PoseCandidates candidates_;
  RowMotion row_motion_;
  bool fits_black_and_white_ = false;
  std::optional<PoseCandidates> misfit_;
  Reason misfit_reason_ = Reason::kPoorFit;
  double look_alike_px_ = 0;  ///< radius of a dot of the largest thing that has a whole ring and is no landmark
};

}  // namespace ninedot
