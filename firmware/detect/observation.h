#pragma once
/// What the detector hands to the pose solvers: the dots of the landmarks seen in one picture.
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>

#include "base/inline_vector.h"
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

/// Sets the outline's axes and their direction to those of the ellipse with these second central moments over its area.
/// \param moments_px2  symmetric; a disc of radius r has r^2 / 4 on the diagonal. Memory: none. Threads: pure.
void set_outline(const Eigen::Matrix2d& moments_px2, DotObservation& dot) noexcept;

/// Of a small disc, which appears as its image under the map's derivative there. \param px_per_m  that derivative
/// \param radius_m  of the disc \return  [px^2]
inline Eigen::Matrix2d disc_moments(const Eigen::Matrix2d& px_per_m, double radius_m) noexcept {
  return 0.25 * radius_m * radius_m * px_per_m * px_per_m.transpose();
}

/// The landmark in one picture, dots numbered (index 0..7 = P1..P8, 8 = P9).
struct LandmarkObservation {
  std::array<DotObservation, kDotCount> dots{};
  /// Sheet to bearing: (x, y, 1) ~ H (X0, Z0, 1), X0 and Z0 in m, x and y normalised (z = 1) with the lens's distortion
  /// removed. Good to about a pixel.
  Eigen::Matrix3d H_ray_plane = Eigen::Matrix3d::Identity();
  /// What speaks against the dot at index k being P1, of one picture alone and whatever the numbering above follows:
  /// the priors of numbering.h as squares of normal deviates, those of the likeliest numbering taken off. The smallest
  /// is 0. 0 for all: nothing is known. [1]
  std::array<double, kRingDotCount> numbering_chi2{};
  int seen_count = 0;
  bool from_pose = false;  ///< computed from a pose that was found without looking for dots
};

/// The same landmark with the dot at index `eighths` (modulo eight) as P1: dots, H_ray_plane and numbering_chi2 turn
/// together, so that every dot stays where it is seen. Memory: none. Threads: pure.
LandmarkObservation renumbered(const LandmarkObservation& seen, int eighths) noexcept;

/// Whether both start a solver from the same place: the same dots are seen, and each of the nine lies in the same
/// direction, to a thousandth of the ring's size. Memory: none. Threads: pure.
bool is_same_reading(const LandmarkObservation& a, const LandmarkObservation& b,
                     const LandmarkGeometry& landmark) noexcept;

/// More landmarks than a room needs around one camera.
inline constexpr std::size_t kMaxLandmarksInView = 16;
using ObservationList = InlineVector<LandmarkObservation, kMaxLandmarksInView>;

}  // namespace ninedot
