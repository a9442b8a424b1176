#pragma once
/// How well one sighting alone says where its sheet is, and which numberings of its dots a place of the camera allows.
#include "base/inline_vector.h"
#include "world/scene.h"

namespace ninedot {

/// 1-sigma of the distance of a sighting's P9 [m]; across the line of sight it is known a hundred times better.
/// \param sighting  index [1]
double distance_sigma_m(const Scene& scene, std::size_t sighting) noexcept;

/// 1-sigma of how the sheet is turned, all axes together [rad]. \param sighting  index [1]
double tilt_sigma_rad(const Scene& scene, std::size_t sighting) noexcept;

/// Which numberings of a sighting's dots turn it most nearly as `R_camera_landmark` would show it: the nearest, and the
/// second where it is nearly as near. None where the sheet faces elsewhere.
/// \param sighting  index [1] \param R_camera_landmark  rotation matrix [1] \return  Choice::turn, indices [1]
InlineVector<std::size_t, 2> turns_for(const Scene& scene, std::size_t sighting,
                                       const Eigen::Matrix3d& R_camera_landmark) noexcept;

}  // namespace ninedot
