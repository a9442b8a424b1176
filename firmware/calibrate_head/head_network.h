#pragma once
/// A head, the landmarks around its foot, and the stops at which it saw them: what is known of all that so far.
///
/// The chain is that of geometry/body.h from the foot on: T_foot_camera = Rz(pan) . tilt axis . Ry(-tilt) . camera .
/// misalignment . optical. The foot is the frame body here, with pan_axis_m and mount_rpy_rad zero: what these are no
/// camera on the head can see.
///
/// Nor can it see, and so these stay as they were: where each angle is zero (AngleTable's anchor), at which height of
/// the pan axis the tilt axis is (tilt_axis_m.z), and at which place of the tilt axis its point is (tilt_axis_m.y).
#include <cstdint>
#include <span>
#include <vector>

#include "calibrate_head/angle_table.h"
#include "calibrate_head/head_stops.h"
#include "geometry/body.h"
#include "geometry/landmark.h"

namespace ninedot {

using FootFromLandmark = Transform<frame::Body, frame::Landmark>;

/// Where a landmark hung during one recording.
struct LandmarkPlace {
  std::size_t recording = 0;  ///< index of it, as in HeadStop
  std::uint16_t id = 0;
  FootFromLandmark T_foot_landmark;
};

struct StopSighting {
  const LandmarkSighting* seen = nullptr;
  std::size_t stop = 0, place = 0;  ///< index of each [1]
  bool is_believed = true;
};

struct HeadNetwork {
  std::span<const HeadStop> stops;
  LandmarkGeometry landmark;
  std::vector<LandmarkPlace> places;
  std::vector<StopSighting> sightings;
  std::vector<bool> is_believed;   ///< of each stop: its told angles are
  std::vector<HeadAngles> angles;  ///< of each stop: the true ones, as the pictures have them

  BodyGeometry body;    ///< from the foot on
  double skew_rad = 0;  ///< by which the tilt axis is not square to the pan axis; 0 unless it is asked for
  AngleTable pan, tilt;
  double pan_spread_rad = 0, tilt_spread_rad = 0;  ///< 1-sigma: of true angles about the table, beside the play
  double variance_factor = 1;                      ///< of the pictures against what they say of themselves [1]

  bool counts(const StopSighting& sighting) const { return sighting.is_believed && is_believed[sighting.stop]; }
};

/// The angles that a stop's told ones stand for by the tables, the play left out.
inline HeadAngles angles_of(const HeadNetwork& network, const HeadAngles& told) {
  return {network.pan.at(told.pan_rad), network.tilt.at(told.tilt_rad)};
}

/// A first guess, from what a configuration says of the head: angles as told, and places of the landmarks with them.
/// Poses that are another reading of their picture (mirror images) are outvoted.
/// \param stops  five at least, and outlive the result
HeadNetwork guess_network(std::span<const HeadStop> stops, const LandmarkGeometry& landmark, const BodyGeometry& body);

/// The direction to a sighting's landmark, foretold by `angles`, against the one that is seen. [rad]
double off_rad(const HeadNetwork& network, const StopSighting& sighting, const HeadAngles& angles);

}  // namespace ninedot
