#include "mapping/sighting_network.h"

#include <algorithm>

#include "base/contract.h"

namespace ninedot {
namespace {

/// One picture may bear a wrong identity, and where it alone joins two parts nothing would show it.
constexpr int kJoiningPictures = 2;

bool is_given(const NetworkLandmark& landmark) { return landmark.exact || landmark.surveyed; }

}  // namespace

double SightingNetwork::chi2_of(const NetworkSighting& sighting) const noexcept {
  return fit_of_sighting(*sighting.seen, landmarks[sighting.landmark].place, frames[sighting.frame].camera, geometry)
      .chi2;
}

int SightingNetwork::freedoms_of(const NetworkSighting& sighting) noexcept {
  return 2 * static_cast<int>(std::ranges::count_if(sighting.seen->dots,
                                                    [](const DotSighting& dot) { return !dot.information.isZero(0); }));
}

SightingNetwork make_network(std::span<const RecordedSightings> frames, const LandmarkMap& map,
                             std::span<const std::uint16_t> exact, const LandmarkGeometry& geometry) {
  EXPECTS(std::ranges::all_of(exact, [&](std::uint16_t id) { return map.find(id) != nullptr; }));
  SightingNetwork network{geometry, {}, {}, {}};
  for (const MappedLandmark& known : map.landmarks()) {
    NetworkLandmark landmark{known.id, std::ranges::count(exact, known.id) > 0, std::nullopt, false, {}};
    if (!landmark.exact && known.has_place && known.covariance.topLeftCorner<3, 3>().trace() > 0)
      landmark.surveyed = known;
    landmark.placed = is_given(landmark);
    if (landmark.placed) landmark.place = known.T_world_landmark;
    network.landmarks.push_back(landmark);
  }
  EXPECTS(std::ranges::any_of(network.landmarks, is_given));
  for (const RecordedSightings& source : frames) {
    NetworkFrame frame{&source, network.sightings.size(), 0, false, {}};
    for (const LandmarkSighting& seen : source.list) {
      const auto landmark = std::ranges::lower_bound(network.landmarks, seen.id, {}, &NetworkLandmark::id);
      if (landmark == network.landmarks.end() || landmark->id != seen.id) continue;
      const OwnPoses own = own_poses(seen, geometry);
      if (own.empty()) continue;
      const auto index = static_cast<std::size_t>(landmark - network.landmarks.begin());
      network.sightings.push_back({network.frames.size(), index, &seen, own, true});
    }
    frame.count = network.sightings.size() - frame.first;
    if (frame.count >= 2)
      network.frames.push_back(frame);
    else
      network.sightings.resize(frame.first);  // it says nothing of places relative to each other
  }
  return network;
}

void drop_unconnected(SightingNetwork& network) {
  std::vector<std::vector<std::size_t>> frames_of(network.landmarks.size());
  for (const NetworkSighting& sighting : network.sightings)
    if (network.counts(sighting)) frames_of[sighting.landmark].push_back(sighting.frame);
  // Outwards from what is given: a landmark that has been reached reaches its pictures, these what else they show.
  std::vector<std::size_t> reached;
  std::vector<bool> is_frame_reached(network.frames.size());
  std::vector<int> pictures(network.landmarks.size());
  for (std::size_t i = 0; i < network.landmarks.size(); ++i)
    if (is_given(network.landmarks[i])) reached.push_back(i), pictures[i] = kJoiningPictures;
  for (std::size_t at = 0; at < reached.size(); ++at)
    for (const std::size_t frame : frames_of[reached[at]]) {
      if (is_frame_reached[frame]) continue;
      is_frame_reached[frame] = true;
      for (const NetworkSighting& beside : network.of(network.frames[frame]))
        if (network.counts(beside) && ++pictures[beside.landmark] == kJoiningPictures)
          reached.push_back(beside.landmark);
    }
  for (std::size_t i = 0; i < network.landmarks.size(); ++i)
    if (pictures[i] < kJoiningPictures) network.landmarks[i].placed = false;
  for (NetworkFrame& frame : network.frames) {
    const auto used = std::ranges::count_if(network.of(frame),
                                            [&](const NetworkSighting& sighting) { return network.counts(sighting); });
    frame.placed = frame.placed && used >= 2;
  }
}

}  // namespace ninedot
