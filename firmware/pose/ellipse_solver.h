#pragma once
/// `solver = "ellipse"`: the founding paper's closed-form method (Martin & Adan, Pattern Recognition 45 (2012)
/// 578-595), equations (3) to (36).
#include "base/result.h"
#include "detect/observation.h"
#include "geometry/camera_model.h"
#include "pose/estimate.h"

namespace ninedot {

/// What the founding paper calibrates off line.
struct EllipseCalibration {
  double kmm_mm_per_px =
      0;  ///< Kmm of (6): millimetres on the sensor per pixel; 0 = 1 / fx with f = 1 (the calibrated camera's own)
  double p1 = 0, p2 = 0, p3 = 0;  ///< F(D') = p1 + p2 D'^p3 (9), D' in mm; p1 = 0: F = Kmm, no refinement
  double cu = 0, cv = 0;          ///< off-centre correction (32, 33) [1/px^2]
};

/// Memory: none beyond the object. Threads: pure after construction.
class EllipseSolver {
 public:
  EllipseSolver(const CameraModel& camera, const LandmarkGeometry& landmark, const EllipseCalibration& calibration);

  /// \error kPoseDegenerate: neither five ring dots nor P9 and one ring dot are visible
  /// The other side's pose comes second, without a covariance. `chi2_above` is the difference of their squared
  /// residuals, in units of a dot centre's variance.
  Result<PoseCandidates> solve(const LandmarkObservation& seen) const noexcept;

 private:
  CameraModel camera_;
  LandmarkGeometry landmark_;
  EllipseCalibration calibration_;
};

}  // namespace ninedot
