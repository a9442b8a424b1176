#pragma once
/// Where a landmark should be in a picture that has not been looked at yet.
#include <Eigen/Core>

#include "detect/observation.h"
#include "geometry/transform.h"

namespace ninedot {

/// A pose says it, or the landmark as it was seen in the frame before.
struct LandmarkForecast {
  /// The landmark's pose is known, and with it which dot is P1. Implicit: a pose is a forecast.
  LandmarkForecast(const CameraFromLandmark& T_camera_landmark) noexcept : is_numbered(true) {
    H_ray_plane << T_camera_landmark.rotation.col(0), T_camera_landmark.rotation.col(2),
        T_camera_landmark.translation_m;
  }
  /// \param trust_numbers  which dot is P1 was known of `seen`, by a track or a code
  LandmarkForecast(const LandmarkObservation& seen, bool trust_numbers) noexcept
      : H_ray_plane(seen.H_ray_plane), is_numbered(trust_numbers) {}

  Eigen::Matrix3d H_ray_plane;  ///< sheet [m] to bearing (z = 1), as in LandmarkObservation
  bool is_numbered;             ///< the dots that are found take the forecast ones' numbers; else the priors decide
};

}  // namespace ninedot
