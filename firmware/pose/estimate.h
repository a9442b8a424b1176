#pragma once
/// What a pose solver answers.
#include <Eigen/Core>

#include "geometry/transform.h"

namespace ninedot {

using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

/// The quantities of the founding paper (Martin & Adan, Pattern Recognition 45 (2012) 578-595, section 3), reported by
/// every solver.
struct EllipseParameters {
  double swing_psi_rad = 0;     ///< between the ring ellipse's major axis and the picture's vertical
  double tilt_phi_rad = 0;      ///< between the line of sight and the sheet's normal
  double pan_theta_rad = 0;     ///< position of the dots along the ellipse
  double distance_m = 0;        ///< D: from P9 to the optical centre
  double image_distance_m = 0;  ///< D' = D + f: from P9 to the image plane
  double deviation_rad = 0;     ///< delta: between the optical axis and the direction to P9 (27)
};

struct PoseEstimate {
  Transform<frame::Landmark, frame::Camera> T_landmark_camera;
  /// Of (position in S0 [m], rotation vector in the camera frame [rad]): R_true = R exp(rotation), t_true = t +
  /// position.
  Matrix6d covariance = Matrix6d::Zero();
  double ambiguity = 0;     ///< 0 = the other planar solution is excluded, 1 = both fit alike
  double rms_px = 0;        ///< residual of the outlines used
  int dots_used = 0;        ///< of nine, partly hidden ones included
  int occlusion_level = 0;  ///< 0 nothing hidden, I..III of the founding paper as 1..3
  EllipseParameters ellipse;
};

}  // namespace ninedot
