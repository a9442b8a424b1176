#pragma once
/// How well a place of the camera in the world explains one landmark's sighting, and which way it should move.
#include <Eigen/Core>

#include "world/sighting.h"

namespace ninedot {

using WorldFromCamera = Transform<frame::World, frame::Camera>;
using WorldFromLandmark = Transform<frame::World, frame::Landmark>;

/// The camera moved by a small step: (position [m, world axes], rotation vector [rad, camera axes]), as the covariance
/// of a pose is given: p + position, R exp(rotation).
using PoseStep = Eigen::Matrix<double, 6, 1>;
using PoseInformation = Eigen::Matrix<double, 6, 6>;

/// \param step  [m, rad]
WorldFromCamera moved_by(const WorldFromCamera& T_world_camera, const PoseStep& step) noexcept;

/// The step from one place to another: moved_by(from, step_between(from, to)) == to.
PoseStep step_between(const WorldFromCamera& from, const WorldFromCamera& to) noexcept;

/// Nearer than this before the optical centre nothing is seen; it keeps projections finite.
inline constexpr double kNearestSeen_m = 1e-3;

/// How a point's ray moves with the camera that sees it. \param p_camera_m  the point, before the camera
/// \param R_world_camera  the camera's axes [1] \return  d(x/z, y/z) by a PoseStep [1/m, 1/rad]
/// Memory: none. Threads: pure.
Eigen::Matrix<double, 2, 6> ray_by_step(const Eigen::Vector3d& p_camera_m,
                                        const Eigen::Matrix3d& R_world_camera) noexcept;

/// Gauss-Newton's equations about a place of the camera; sums of them over several sightings are those of all together:
/// (sum of normal) step = -(sum of gradient).
struct SightingFit {
  double chi2 = 0;                                   ///< of all dots seen, two each [1]
  int dots = 0;                                      ///< seen
  PoseInformation normal = PoseInformation::Zero();  ///< J^T W J [1/m^2, 1/(m rad), 1/rad^2]
  PoseStep gradient = PoseStep::Zero();              ///< J^T W r [1/m, 1/rad]

  SightingFit& operator+=(const SightingFit& other) noexcept;
};

/// The sighting's own turn eliminated (place_uncertainty.h).
/// \return  chi2 infinite, the rest zero: a dot that is seen would lie behind the camera
/// Memory: none. Threads: pure.
SightingFit fit_of_sighting(const LandmarkSighting& sighting, const WorldFromLandmark& T_world_landmark,
                            const WorldFromCamera& T_world_camera, const LandmarkGeometry& landmark) noexcept;

}  // namespace ninedot
