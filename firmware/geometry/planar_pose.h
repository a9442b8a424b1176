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
#include "geometry/optimiser_statistics.h"
#include "geometry/plane_point.h"
#include "geometry/transform.h"

namespace ninedot {

struct PlanarPose {
  CameraFromLandmark T_camera_landmark;
  double rms = 0;  ///< weighted root mean square distance between seen and predicted points, at z = 1
  OptimiserStatistics statistics;
};

/// Both local minima of the reprojection error, smaller rms first. Where the picture has a single minimum (strong
/// perspective, or a frontal view) both entries may be the same pose.
using PlanarPoses = std::array<PlanarPose, 2>;

/// Solves for the pose of the plane. In every solution all points are in front of the camera and the camera is on the
/// printed side (Y0 > 0).
/// \param points  seen as rays at z = 1; at least four, no three of four on a line
/// \error kPoseDegenerate: too few points, points on a line, or a mirrored arrangement, which no printed side can show
/// Memory: none. Threads: pure.
Result<PlanarPoses> solve_planar_pose(std::span<const PlanePoint> points) noexcept;

/// The one whose start fits better, at little more than half the cost: where noise decides between them, it may be the
/// one that solve_planar_pose() has second. \param points, \error  as above
/// Memory: none. Threads: pure.
Result<PlanarPose> solve_likelier_planar_pose(std::span<const PlanePoint> points) noexcept;

/// Minimises the reprojection error from a start pose.
/// \param start  all points in front of the camera (contract by result: otherwise rms is infinite)
/// Memory: none. Threads: pure.
PlanarPose refine_planar_pose(std::span<const PlanePoint> points, const CameraFromLandmark& start) noexcept;

/// Plane to z = 1: (x, y, 1) ~ H (X0, Z0, 1), by the weighted normalised linear method, scaled so that the third
/// coordinate is positive at the points.
/// \error kPoseDegenerate: as above
Result<Eigen::Matrix3d> fit_homography(std::span<const PlanePoint> points) noexcept;

/// How far away such a map has the plane's origin, by how large it draws what lies there: the larger singular value of
/// its derivative is 1 / depth (IPPE, as above; where the ray is far from the axis and the plane tilted, within a few
/// per cent). How it foreshortens, which a few points that are close together hardly tell, is not asked.
/// \param H  from [m] to rays at z = 1 [1]; third coordinate of the origin > 0 (contract)
/// \return  along the camera's axis [m]
/// Memory: none. Threads: pure.
double depth_of_origin(const Eigen::Matrix3d& H) noexcept;

}  // namespace ninedot
