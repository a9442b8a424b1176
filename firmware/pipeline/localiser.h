#pragma once
/// One frame's path: picture -> dots -> landmark -> pose with its uncertainty -> report. The whole path is in `process`.
#include <memory>

#include "detect/detector.h"
#include "pose/ellipse_solver.h"
#include "pose/full_solver.h"
#include "proto/report.h"

namespace ninedot {

struct LocaliserOptions {
  LandmarkGeometry landmark;
  DetectorOptions detector;
  Solver solver = Solver::kFull;
  EllipseCalibration ellipse;
  bool tracking = true;           ///< look where the landmark was before searching the whole picture
  double max_ambiguity = 0.7;     ///< above: Report::ambiguous
  std::uint16_t landmark_id = 0;
  Transform<frame::World, frame::Landmark> T_world_landmark;
  bool calibrated = true;
};

/// Memory: everything is allocated by the constructor. Threads: one caller.
class Localiser {
 public:
  Localiser(const CameraModel& camera, const LocaliserOptions& options);

  /// Fills every field of the next report but the published_at and latency of `report`, which comes in as the report
  /// of the frame before: when nothing is found its pose stays, with valid = false and the reason.
  void process(const ImageView& luma, MonoTime exposed_at, std::uint64_t frame_number, Report& report) noexcept;

  /// A frame that could not be had: the pose stays, not valid, with the reason of `error`.
  static void report_failure(const Error& error, Report& report) noexcept;

  /// The last landmark found, for overlays; null when the last frame showed none.
  const LandmarkObservation* last_observation() const noexcept;

 private:
  LocaliserOptions options_;
  Detector detector_;
  FullSolver full_;
  EllipseSolver ellipse_;
  LandmarkObservation seen_{};
  PoseEstimate pose_{};
  bool seen_last_ = false;
};

}  // namespace ninedot
