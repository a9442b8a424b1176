#pragma once
/// Where a landmark should be in a picture that has not been looked at yet.
#include <Eigen/Core>
#include <cstdint>

#include "detect/observation.h"
#include "geometry/transform.h"

namespace ninedot {

/// How the dots that are found there get their numbers.
enum class ForecastNumbers : std::uint8_t {
  kByPriors,  ///< nothing is foretold
  kForetold,  ///< as the forecast's dots where they are met; elsewhere it is another view, and the priors know better
  kCertain,   ///< by colours: as the forecast's dots, or it is not this landmark. The priors know nothing of its roll
};

/// A pose says it, or the landmark as it was seen in the frame before.
struct LandmarkForecast {
  /// The landmark's pose is known, and with it which dot is P1. Implicit: a pose is a forecast.
  LandmarkForecast(const CameraFromLandmark& T_camera_landmark,
                   ForecastNumbers numbers_known = ForecastNumbers::kForetold) noexcept
      : numbers(numbers_known) {
    H_ray_plane << T_camera_landmark.rotation.col(0), T_camera_landmark.rotation.col(2),
        T_camera_landmark.translation_m;
  }
  LandmarkForecast(const LandmarkObservation& seen, ForecastNumbers numbers_known) noexcept
      : H_ray_plane(seen.H_ray_plane), numbers(numbers_known) {}

  Eigen::Matrix3d H_ray_plane;  ///< sheet [m] to bearing (z = 1), as in LandmarkObservation
  ForecastNumbers numbers;
};

}  // namespace ninedot
