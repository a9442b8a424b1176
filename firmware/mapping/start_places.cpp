#include "mapping/start_places.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <queue>
#include <utility>

#include "mapping/chi_square.h"

namespace ninedot {
namespace {

/// A link is weak with fewer agreeing pictures than this, or a smaller share of them: two may be wrong together, and
/// where every second one disagrees the right ones may be those. A wrong identity gives such links.
constexpr std::size_t kFewPictures = 3;
constexpr double kSmallShare = 0.6;
/// Odds of e^-5 for another opinion.
constexpr double kNarrowLead_chi2 = 10;
/// How much a rotation counts beside a position: what it moves at this distance, some way to the next landmark. [m]
constexpr double kArm_m = 2.0;

bool is_weak(const PlaceConsensus& found) {
  return found.agreeing < kFewPictures ||
         static_cast<double>(found.agreeing) < kSmallShare * static_cast<double>(found.pictures) ||
         found.lead_chi2 < kNarrowLead_chi2;
}

double variance_m2(const PlaceConsensus& found) {
  return found.covariance.topLeftCorner<3, 3>().trace() +
         kArm_m * kArm_m * found.covariance.bottomRightCorner<3, 3>().trace();
}

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

WorldFromCamera camera_from(const WorldFromLandmark& place, const OwnPose& pose) {
  return place * pose.T_camera_landmark.inverse();
}

/// Where `seen` is in the world of the camera, and how uncertain that makes it.
/// \param camera_covariance  of T_world_camera as a PoseStep
PlaceVote vote_from(std::size_t picture, const WorldFromCamera& T_world_camera,
                    const PoseInformation& camera_covariance, const OwnPose& seen) {
  // The camera in the sheet's frame, (R, p) with its step (dp, r); then by dp' and r' for the camera in the world:
  // T_world_sheet = T_world_camera T_camera_sheet turns about the world's axes by R_world_camera (r' - r), and its
  // position by dp' + [R_ws p]x turn - R_ws dp.
  const WorldFromLandmark place = T_world_camera * seen.T_camera_landmark;
  const Eigen::Vector3d p_m = seen.T_camera_landmark.inverse().translation_m;
  const Eigen::Matrix3d lever = cross_matrix(place.rotation * p_m);
  Eigen::Matrix<double, 6, 6> J_camera, J_sheet;
  J_camera << Eigen::Matrix3d::Identity(), lever * T_world_camera.rotation, Eigen::Matrix3d::Zero(),
      T_world_camera.rotation;
  J_sheet << -place.rotation, -lever * T_world_camera.rotation, Eigen::Matrix3d::Zero(), -T_world_camera.rotation;
  return {picture, place,
          J_camera * camera_covariance * J_camera.transpose() + J_sheet * seen.covariance * J_sheet.transpose(), 0};
}

/// All ways of reading one picture of two landmarks.
void add_votes(const NetworkSighting& from, const NetworkSighting& to, std::vector<PlaceVote>& votes) {
  for (const OwnPose& a : from.own)
    for (const OwnPose& b : to.own) {
      PlaceVote vote = vote_from(from.frame, camera_from({}, a), a.covariance, b);
      vote.penalty_chi2 = a.chi2 - from.own[0].chi2 + b.chi2 - to.own[0].chi2;
      votes.push_back(vote);
    }
}

/// Sum over the sightings of what each says against the camera's place; one that is wrong altogether says little more
/// than one that is half wrong.
double disagreement(const SightingNetwork& network, std::span<const PlacedSighting> placed,
                    const WorldFromCamera& camera) {
  double sum = 0;
  for (const PlacedSighting& sighting : placed) {
    const double chi2 = fit_of_sighting(*sighting.seen, sighting.T_world_landmark, camera, network.geometry).chi2;
    sum += std::log1p(std::fmin(chi2, std::numeric_limits<double>::max()) / chi2_limit(2 * kDotCount));
  }
  return sum;
}

}  // namespace

std::vector<LandmarkLink> find_links(const SightingNetwork& network) {
  std::map<std::pair<std::size_t, std::size_t>, std::vector<PlaceVote>> votes;
  for (const NetworkFrame& frame : network.frames)
    for (const NetworkSighting& a : network.of(frame))
      for (const NetworkSighting& b : network.of(frame))
        if (a.landmark < b.landmark) add_votes(a, b, votes[{a.landmark, b.landmark}]);
  std::vector<LandmarkLink> links;
  for (const auto& [pair, list] : votes) links.push_back({pair.first, pair.second, find_consensus(list)});
  return links;
}

void place_landmarks(SightingNetwork& network, const std::vector<LandmarkLink>& links) {
  std::vector<std::vector<const LandmarkLink*>> of(network.landmarks.size());
  for (const LandmarkLink& link : links) {
    of[link.from].push_back(&link);
    of[link.to].push_back(&link);
  }
  using Entry = std::tuple<bool, double, const LandmarkLink*>;  // weak ones last, then by variance
  std::priority_queue<Entry, std::vector<Entry>, std::greater<>> next;
  const auto reach = [&](std::size_t landmark) {
    for (const LandmarkLink* link : of[landmark])
      next.emplace(is_weak(link->in_from), variance_m2(link->in_from), link);
  };
  for (std::size_t i = 0; i < network.landmarks.size(); ++i)
    if (network.landmarks[i].placed) reach(i);
  while (!next.empty()) {
    const LandmarkLink& link = *std::get<2>(next.top());
    next.pop();
    NetworkLandmark &from = network.landmarks[link.from], &to = network.landmarks[link.to];
    if (from.placed == to.placed) continue;
    // The link's place is the second landmark's in the first one's frame.
    const Transform<frame::Landmark, frame::Landmark> T_from_to{link.in_from.place.rotation,
                                                                link.in_from.place.translation_m};
    if (from.placed)
      to.place = from.place * T_from_to;
    else
      from.place = to.place * T_from_to.inverse();
    const std::size_t reached = from.placed ? link.to : link.from;
    network.landmarks[reached].placed = true;
    reach(reached);
  }
}

void place_frames(SightingNetwork& network) {
  std::vector<PlacedSighting> placed;
  for (NetworkFrame& frame : network.frames) {
    placed.clear();
    for (const NetworkSighting& sighting : network.of(frame))
      if (network.landmarks[sighting.landmark].placed)
        placed.push_back({sighting.seen, network.landmarks[sighting.landmark].place});
    frame.placed = placed.size() >= 2;
    double best = std::numeric_limits<double>::infinity();
    for (const NetworkSighting& sighting : network.of(frame)) {
      if (!network.landmarks[sighting.landmark].placed) continue;
      for (const OwnPose& pose : sighting.own) {
        const WorldFromCamera camera = camera_from(network.landmarks[sighting.landmark].place, pose);
        const double cost = disagreement(network, placed, camera);
        if (cost < best) best = cost, frame.camera = camera;
      }
    }
  }
}

std::optional<PlaceConsensus> place_among_others(const SightingNetwork& network, std::size_t landmark,
                                                 const std::vector<std::size_t>& sightings_of_landmark) {
  std::vector<PlaceVote> votes;
  std::vector<PlacedSighting> others;
  for (const std::size_t index : sightings_of_landmark) {
    const NetworkSighting& sighting = network.sightings[index];
    const NetworkFrame& frame = network.frames[sighting.frame];
    others.clear();
    for (const NetworkSighting& other : network.of(frame))
      if (other.landmark != landmark && network.counts(other))
        others.push_back({other.seen, network.landmarks[other.landmark].place});
    if (others.empty()) continue;
    const CameraFit fit = fit_camera(others, frame.camera, network.geometry);
    SightingFit at;
    for (const PlacedSighting& other : others)
      at += fit_of_sighting(*other.seen, other.T_world_landmark, fit.T_world_camera, network.geometry);
    const PoseInformation covariance = at.normal.inverse();
    if (!std::isfinite(fit.chi2) || !covariance.allFinite()) continue;
    for (const OwnPose& pose : sighting.own) {
      votes.push_back(vote_from(sighting.frame, fit.T_world_camera, covariance, pose));
      votes.back().penalty_chi2 = pose.chi2 - sighting.own[0].chi2;
    }
  }
  if (votes.empty()) return std::nullopt;
  return find_consensus(votes);
}

}  // namespace ninedot
