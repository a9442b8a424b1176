#pragma once
/// Which lengths make a landmark.
#include <cmath>
#include <numbers>

#include "geometry/landmark.h"

namespace ninedot {

/// What is wrong with the lengths of a landmark. Its own lengths are in the unit of those: [m], or [mm] where a caller
/// has filled the geometry in mm (only their ratios count).
struct LandmarkFaults {
  bool ring_dots_touch = false;      ///< neighbours of the ring
  bool centre_touches_ring = false;  ///< the centre dot and those of the ring
  bool centre_not_largest = false;   ///< by its size the centre dot is told from the others
  double dot_diameter_below = 0;     ///< what mends the first
  double centre_diameter_below = 0;  ///< what mends the second
};
inline LandmarkFaults find_landmark_faults(const LandmarkGeometry& landmark) noexcept {
  LandmarkFaults faults;
  // Neighbours on a regular octagon are 2 R sin(22.5 deg) apart.
  faults.dot_diameter_below = 2 * landmark.ring_radius_m * std::sin(std::numbers::pi / kRingDotCount);
  faults.centre_diameter_below = 2 * landmark.ring_radius_m - 2 * landmark.dot_radius_m;
  faults.ring_dots_touch = 2 * landmark.dot_radius_m >= faults.dot_diameter_below;
  faults.centre_touches_ring = 2 * landmark.centre_radius_m >= faults.centre_diameter_below;
  faults.centre_not_largest = landmark.centre_radius_m <= landmark.dot_radius_m;
  return faults;
}

}  // namespace ninedot
