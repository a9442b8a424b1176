#pragma once
/// How far a landmark's place in the map may be off, and what that takes from its sighting.
#include "world/sighting_fit.h"

namespace ninedot {

/// Of a landmark's place: (position [m, world axes], rotation vector [rad, world axes]): t + position,
/// exp(rotation) R. Of a camera's place: that of a PoseStep.
using PoseCovariance = Eigen::Matrix<double, 6, 6>;

/// A landmark that hangs elsewhere than the map says looks as if the camera stood elsewhere: rays know only of the one
/// before the other. So an error of the landmark's place is a step of the camera for this sighting alone; to first
/// order step = B error, B = (-1, -[landmark - camera]x; 0, -R_camera_world).
/// \param place_covariance  of the landmark's place [m^2, m rad, rad^2]
/// \return  of the camera's step, B covariance B^T [m^2, m rad, rad^2]
/// Memory: none. Threads: pure.
PoseCovariance step_covariance_of_place(const PoseCovariance& place_covariance,
                                        const WorldFromLandmark& T_world_landmark,
                                        const WorldFromCamera& T_world_camera) noexcept;

/// Of LandmarkSighting::turn_sigma_rad: a step of the camera for this sighting alone as well.
/// \return  of the camera's step [m^2, m rad, rad^2] Memory: none. Threads: pure.
PoseCovariance step_covariance_of_turn(double turn_sigma_rad) noexcept;

/// What is left of a sighting's equations when the camera stands, for it, a step aside that is normal with
/// `step_covariance`, and the likeliest of those steps is taken: its six unknowns eliminated (Schur's complement).
/// chi2 = min over s of chi2 + 2 g s + s N s + s C^-1 s; N' = (1 + N C)^-1 N, g' = (1 + N C)^-1 g. No inverse of C: it
/// may be singular. \param step_covariance  [m^2, m rad, rad^2]
/// Memory: none. Threads: pure.
SightingFit softened(const SightingFit& fit, const PoseCovariance& step_covariance) noexcept;

/// The same of step_covariance_of_turn(turn_sigma_rad): three unknowns eliminated, not six. \pre turn_sigma_rad > 0
/// Memory: none. Threads: pure.
SightingFit softened_by_turn(const SightingFit& fit, double turn_sigma_rad) noexcept;

}  // namespace ninedot
