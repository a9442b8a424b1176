#pragma once
/// Where in a picture the middles of a landmark's dots are.
#include <Eigen/Core>
#include <array>

#include "geometry/landmark.h"

namespace ninedot {

/// Where a dot's middle is, as the camera's optical centre sees it.
struct DotSighting {
  Eigen::Vector2d ray = Eigen::Vector2d::Zero();          ///< x/z, y/z in the camera frame, the lens taken out [1]
  Eigen::Matrix2d information = Eigen::Matrix2d::Zero();  ///< inverse covariance of `ray` [1]; zero: it is not seen
};
using DotSightings = std::array<DotSighting, kDotCount>;  ///< P1..P8, P9

/// The same dots when the dot at index `eighths` (modulo eight) is called P1. Memory: none. Threads: pure.
DotSightings renumbered(const DotSightings& dots, int eighths) noexcept;

}  // namespace ninedot
