#pragma once
/// One of the two poses that an ellipse allows: the sheet leaning to one or to the other side of its major axis.
#include <Eigen/Core>
#include <array>

#include "base/result.h"
#include "geometry/camera_model.h"
#include "geometry/landmark.h"
#include "pose/ellipse_sight.h"
#include "pose/ellipse_solver.h"

namespace ninedot {

struct EllipseCandidate {
  Transform<frame::Landmark, frame::Camera> T_landmark_camera;
  double oriented_swing_rad = 0;  ///< psi or psi + pi, see pose_from_parameters
  double image_distance_m = 0;    ///< D'
  Eigen::Vector2d p9{0, 0};       ///< where P9's middle is seen, z = 1
  /// Centre of each dot's outline minus picture of its middle, z = 1; zero where the paper's own approximations hold.
  std::array<Eigen::Vector2d, kDotCount> outline_shift{};
};

/// The unchanging part of the solver.
struct EllipseProblem {
  CameraModel camera;
  LandmarkGeometry landmark;
  EllipseCalibration calibration;

  /// Whether the founding paper's off-line calibration is in use: then its formulas are taken literally, because Kmm,
  /// F(D'), cu and cv were fitted with them. Otherwise the exact relations stand in for them.
  bool is_paper_calibrated() const noexcept { return calibration.kmm_mm_per_px > 0; }
};

/// The candidate from which both sides start.
/// \error kPoseDegenerate: no ellipse through the dots
Result<EllipseCandidate> start_candidate(const EllipseProblem& problem, const EllipseSight& sight) noexcept;

/// One pass of steps 3 to 6 of the paper: centring, ellipse, distance, tilt, swing, pan.
/// \param before  gives the side (its swing is followed to within a right angle), the dots' outline shifts, and P9 at
/// level III Memory: none. Threads: pure.
Result<EllipseCandidate> improve_candidate(const EllipseProblem& problem, const EllipseSight& sight,
                                           const EllipseCandidate& before) noexcept;

/// The candidate of one side: passes until the outline shifts and P9 rest.
/// \param start  its swing chooses the side
Result<EllipseCandidate> solve_candidate(const EllipseProblem& problem, const EllipseSight& sight,
                                         const EllipseCandidate& start) noexcept;

/// Predicted minus seen outline centre of each dot [px], zero for hidden dots.
using OutlineResiduals = Eigen::Matrix<double, 2, static_cast<int>(kDotCount)>;
OutlineResiduals outline_residuals_px(const EllipseProblem& problem, const EllipseSight& sight,
                                      const EllipseCandidate& candidate) noexcept;

}  // namespace ninedot
