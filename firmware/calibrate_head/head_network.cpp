#include "calibrate_head/head_network.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "base/contract.h"
#include "base/units.h"

namespace ninedot {
namespace {

/// Where pictures and told angles together may err by in the beginning: a table that is 10 % wrong at 30 deg.
constexpr double kFirstSpread_rad = 3 * kRadPerDeg;

/// How much two places of one landmark differ. [1]
double difference(const FootFromLandmark& a, const FootFromLandmark& b) {
  return log_so3(a.rotation.transpose() * b.rotation).norm() +
         (a.translation_m - b.translation_m).norm() / std::max(0.1, a.translation_m.norm());
}

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

struct Vote {
  FootFromLandmark place;
  double spread = 0;  // median difference to the others [1]
};

/// The one that is nearest to most.
Vote most_agreed(const std::vector<FootFromLandmark>& candidates) {
  Vote best{{}, std::numeric_limits<double>::infinity()};
  for (const FootFromLandmark& candidate : candidates) {
    std::vector<double> differences;
    for (const FootFromLandmark& other : candidates) differences.push_back(difference(candidate, other));
    if (const double spread = median(std::move(differences)); spread < best.spread) best = {candidate, spread};
  }
  return best;
}

AngleTable straight_table(std::span<const AxisStop> stops, double sign) {
  AngleTable table{even_knots(stops, 2), {}, 0};
  const double anchor = anchor_rad(table.told_rad);
  for (const double told_rad : table.told_rad) table.angle_rad.push_back(anchor + sign * (told_rad - anchor));
  return table;
}

}  // namespace

double place_landmarks(HeadNetwork& network) {
  std::vector<std::vector<FootFromLandmark>> candidates(network.places.size());
  for (const StopSighting& sighting : network.sightings) {
    const HeadAngles angles = angles_of(network, network.stops[sighting.stop].told);
    candidates[sighting.place].push_back(camera_on_body(network.body, angles).T_body_camera *
                                         sighting.seen->T_camera_landmark);
  }
  double spread = 0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const Vote vote = most_agreed(candidates[i]);
    network.places[i].T_foot_landmark = vote.place;
    spread += vote.spread * static_cast<double>(candidates[i].size());
  }
  return spread;
}

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

  HeadNetwork best;
  double least = std::numeric_limits<double>::infinity();
  for (const double pan_sign : {1.0, -1.0}) {
    for (const double tilt_sign : {1.0, -1.0}) {
      network.pan = straight_table(pan, pan_sign);
      network.tilt = straight_table(tilt, tilt_sign);
      if (const double spread = place_landmarks(network); spread < least) best = network, least = spread;
    }
  }
  for (const HeadStop& stop : stops) best.angles.push_back(angles_of(best, stop.told));
  return best;
}

double off_rad(const HeadNetwork& network, const StopSighting& sighting, const HeadAngles& angles) {
  const Eigen::Vector3d foretold = camera_on_body(network.body, angles).T_body_camera.inverse() *
                                   network.places[sighting.place].T_foot_landmark.translation_m;
  const Eigen::Vector3d seen = sighting.seen->T_camera_landmark.translation_m;
  return std::atan2(foretold.cross(seen).norm(), foretold.dot(seen));
}

}  // namespace ninedot
