#include "calibrate_head/head_network.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "base/contract.h"
#include "base/median.h"
#include "base/units.h"

namespace ninedot {
namespace {

/// In the beginning: a table that is 10 % wrong at 30 deg. One that is wrong by more, or by its sign, has little weight
/// then, and the pictures find the angles.
constexpr double kFirstSpread_rad = 3 * kRadPerDeg;

/// How much two places of one landmark differ. [1]
double difference(const FootFromLandmark& a, const FootFromLandmark& b) {
  return log_so3(a.rotation.transpose() * b.rotation).norm() +
         (a.translation_m - b.translation_m).norm() / std::max(0.1, a.translation_m.norm());
}

/// The one that is nearest to most.
FootFromLandmark most_agreed(const std::vector<FootFromLandmark>& candidates) {
  FootFromLandmark best;
  double least = std::numeric_limits<double>::infinity();
  for (const FootFromLandmark& candidate : candidates) {
    std::vector<double> differences;
    for (const FootFromLandmark& other : candidates) differences.push_back(difference(candidate, other));
    if (const double typical = median(std::move(differences)); typical < least) best = candidate, least = typical;
  }
  return best;
}

AngleTable table_as_told(std::span<const AxisStop> stops) {
  const std::vector<double> knots = even_knots(stops, 2);
  return {knots, knots, 0};
}

/// Where most of their sightings have them, by chain and tables as they are.
void place_landmarks(HeadNetwork& network) {
  std::vector<std::vector<FootFromLandmark>> candidates(network.places.size());
  for (const StopSighting& sighting : network.sightings) {
    const HeadAngles angles = angles_of(network, network.stops[sighting.stop].told);
    candidates[sighting.place].push_back(camera_on_body(network.body, angles).T_body_camera *
                                         sighting.seen->T_camera_landmark);
  }
  for (std::size_t i = 0; i < candidates.size(); ++i) network.places[i].T_foot_landmark = most_agreed(candidates[i]);
}

}  // namespace

HeadNetwork guess_network(std::span<const HeadStop> stops, const LandmarkGeometry& landmark, const BodyGeometry& body) {
  EXPECTS(stops.size() >= 5);
  HeadNetwork network;
  network.stops = stops;
  network.landmark = landmark;
  network.body.tilt_axis_m = body.tilt_axis_m;
  network.body.camera_m = body.camera_m;
  network.body.camera_rpy_rad = body.camera_rpy_rad;
  network.pan_spread_rad = network.tilt_spread_rad = kFirstSpread_rad;
  network.is_believed.assign(stops.size(), true);
  std::map<std::pair<std::size_t, std::uint16_t>, std::size_t> known;
  std::vector<AxisStop> pan, tilt;
  for (std::size_t i = 0; i < stops.size(); ++i) {
    pan.push_back({stops[i].told.pan_rad, 0, 0});
    tilt.push_back({stops[i].told.tilt_rad, 0, 0});
    for (const LandmarkSighting& seen : stops[i].seen) {
      const auto [place, is_new] = known.try_emplace({stops[i].recording, seen.id}, network.places.size());
      if (is_new) network.places.push_back({stops[i].recording, seen.id, {}});
      network.sightings.push_back({&seen, i, place->second, true});
    }
  }

  network.pan = table_as_told(pan);
  network.tilt = table_as_told(tilt);
  place_landmarks(network);
  for (const HeadStop& stop : stops) network.angles.push_back(stop.told);
  return network;
}

double off_rad(const HeadNetwork& network, const StopSighting& sighting, const HeadAngles& angles) {
  const Eigen::Vector3d foretold = camera_on_body(network.body, angles).T_body_camera.inverse() *
                                   network.places[sighting.place].T_foot_landmark.translation_m;
  const Eigen::Vector3d seen = sighting.seen->T_camera_landmark.translation_m;
  return std::atan2(foretold.cross(seen).norm(), foretold.dot(seen));
}

}  // namespace ninedot
