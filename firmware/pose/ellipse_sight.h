#pragma once
/// What the ellipse solver looks at: the observation with the lens's distortion removed, and the occlusion level.
#include <Eigen/Core>
#include <array>
#include <cstddef>

#include "base/result.h"
#include "detect/observation.h"
#include "geometry/camera_model.h"

namespace ninedot {

/// Section 5 of Martin & Adan, Pattern Recognition 45 (2012) 578-595.
enum class Occlusion : int {
  kNone = 0,
  kLevelI = 1,    ///< one or two ring dots missing, P9 visible: the ellipse of the others
  kLevelII = 2,   ///< more than two ring dots missing: P9's own contour, scaled, stands for the ring
  kLevelIII = 3,  ///< P9 missing: the ring alone
};

inline constexpr std::size_t kContourPoints =
    8;  ///< as many as ring dots, so that both ellipses rest on as many points

/// All points at z = 1, distortion removed.
struct EllipseSight {
  Occlusion occlusion = Occlusion::kNone;
  std::array<bool, kDotCount> seen{};
  /// Of the projected discs' outlines, not of the discs; z = 1.
  std::array<Eigen::Vector2d, kDotCount> outline_centres{};
  std::array<Eigen::Vector2d, kContourPoints> contour{};  ///< of P9, z = 1; at level II only
  int seen_count = 0;
};

/// \error kPoseDegenerate: neither five ring dots nor P9 (with its axes) and one ring dot are visible, or a dot lies
///        outside the lens's valid field
/// Memory: none. Threads: pure.
Result<EllipseSight> make_ellipse_sight(const CameraModel& camera, const LandmarkObservation& seen) noexcept;

}  // namespace ninedot
