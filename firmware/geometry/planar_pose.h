#pragma once
/// Where a plane is, from points on it and the rays on which they are seen: both solutions.
///
/// Collins & Bartoli, "Infinitesimal Plane-based Pose Estimation", IJCV 2014 (IPPE), from a homography by the
/// normalised linear method (Hartley & Zisserman, Multiple View Geometry, algorithm 4.2); then Levenberg and
/// Marquardt's method.
#include <Eigen/Core>
#include <array>
#include <span>

#include "base/result.h"
#include "geometry/transform.h"

namespace ninedot {

/// One point of the landmark's plane Y0 = 0 and where the camera sees it.
struct PlanePoint {
  Eigen::Vector2d plane_m;     ///< (X0, Z0)
  Eigen::Vector2d normalised;  ///< its ray, frame camera, z = 1, distortion removed
  double weight = 1;           ///< of its squared residual, >= 0
};

struct PlanarPose {
  Transform<frame::Camera, frame::Landmark> T_camera_landmark;
  double rms = 0;  ///< weighted root mean square distance between seen and predicted points, at z = 1
};

/// Both local minima of the reprojection error, smaller rms first. Where the picture has a single minimum (strong
/// perspective, or a frontal view) both entries may be the same pose.
using PlanarPoses = std::array<PlanarPose, 2>;

/// Solves for the pose of the plane. In every solution all points are in front of the camera and the camera is on the
/// printed side (Y0 > 0).
/// \param points  at least four, no three of four on a line
/// \error kPoseDegenerate: too few points, points on a line, or a mirrored arrangement, which no printed side can show
/// Memory: none. Threads: pure.
Result<PlanarPoses> solve_planar_pose(std::span<const PlanePoint> points) noexcept;

/// Minimises the reprojection error from a start pose.
/// \param start  all points in front of the camera (contract by result: otherwise rms is infinite)
/// Memory: none. Threads: pure.
PlanarPose refine_planar_pose(std::span<const PlanePoint> points,
                              const Transform<frame::Camera, frame::Landmark>& start) noexcept;

/// Plane to z = 1: (x, y, 1) ~ H (X0, Z0, 1), by the weighted normalised linear method, scaled so that the third
/// coordinate is positive at the points.
/// \error kPoseDegenerate: as above
Result<Eigen::Matrix3d> fit_homography(std::span<const PlanePoint> points) noexcept;

}  // namespace ninedot
