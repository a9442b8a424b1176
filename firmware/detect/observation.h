#pragma once
/// What the detector hands to the pose solvers: the dots of one landmark as seen in one picture.
#include <Eigen/Core>
#include <array>
#include <cstdint>

#include "geometry/landmark.h"

namespace ninedot {

/// One dot in the picture. Coordinates in px of the (distorted) picture, pixel centres at integers.
struct DotObservation {
  bool seen = false;                  ///< enough of its outline is visible to be used
  float visible_fraction = 0;         ///< of its outline, 0..1
  Eigen::Vector2d centroid_px{0, 0};  ///< centroid of the dark area = centre of the projected disc's outline
  double semi_major_px = 0;           ///< of the outline, point spread removed
  double semi_minor_px = 0;
  double angle_rad = 0;  ///< of the major axis, from +x towards +y, (-pi/2, pi/2]
};

/// The landmark in one picture, dots numbered (index 0..7 = P1..P8, 8 = P9).
struct LandmarkObservation {
  std::array<DotObservation, kDotCount> dots{};
  /// Sheet to bearing: (x, y, 1) ~ H (X0, Z0, 1), X0 and Z0 in m, x and y normalised (z = 1) with the lens's distortion
  /// removed. Good to about a pixel.
  Eigen::Matrix3d H_ray_plane = Eigen::Matrix3d::Identity();
  int seen_count = 0;
  bool from_pose = false;  ///< computed from a pose that was found without looking for dots
};

/// More in one picture than these are not looked at.
inline constexpr std::size_t kMaxLandmarksInView = 16;

}  // namespace ninedot
