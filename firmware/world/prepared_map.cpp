#include "world/prepared_map.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/contract.h"
#include "world/landmark_codes.h"

namespace ninedot {

std::vector<PlacedLandmark> placed_landmarks(const LandmarkMap& map) {
  std::vector<PlacedLandmark> placed;
  for (const MappedLandmark& mapped : map.landmarks())
    placed.push_back({.T_world_landmark = mapped.T_world_landmark,
                      .covariance = mapped.covariance,
                      .has_place = mapped.has_place,
                      .is_black_and_white = is_black_and_white(mapped.code)});
  return placed;
}

PreparedMap::PreparedMap(std::vector<PlacedLandmark> landmarks) : landmarks_(std::move(landmarks)) {
  EXPECTS(landmarks_.size() <= LandmarkMap::kCapacity);
  Eigen::AlignedBox3d hall_m;
  for (std::size_t i = 0; i < landmarks_.size(); ++i) {
    if (!landmarks_[i].has_place || !landmarks_[i].is_black_and_white) continue;
    anonymous_.push_back(static_cast<std::uint16_t>(i));
    hall_m.extend(place_m(i));
    worst_place_sigma_m_ =
        std::max(worst_place_sigma_m_, std::sqrt(landmarks_[i].covariance.topLeftCorner<3, 3>().trace()));
  }
  if (anonymous_.empty()) return;
  hall_m.sizes().maxCoeff(&axis_);
  const auto along = [this](std::uint16_t landmark) { return place_m(landmark)(axis_); };
  std::ranges::sort(anonymous_, {}, along);
  for (std::size_t a = 0; a < anonymous_.size(); ++a) {
    for (std::size_t b = a + 1; b < anonymous_.size(); ++b) {
      if (along(anonymous_[b]) - along(anonymous_[a]) > kFarthestPair_m) break;
      const double distance_m = (place_m(anonymous_[b]) - place_m(anonymous_[a])).norm();
      if (distance_m <= kFarthestPair_m)
        pairs_.push_back({static_cast<float>(distance_m), anonymous_[a], anonymous_[b]});
    }
  }
  std::ranges::sort(pairs_, {}, &LandmarkPair::distance_m);
}

std::span<const LandmarkPair> PreparedMap::pairs_at(double least_m, double most_m) const noexcept {
  const auto first = std::ranges::lower_bound(pairs_, static_cast<float>(least_m), {}, &LandmarkPair::distance_m);
  const auto end =
      std::ranges::upper_bound(first, pairs_.end(), static_cast<float>(most_m), {}, &LandmarkPair::distance_m);
  return {first, end};
}

bool PreparedMap::find_nearby(const Eigen::Vector3d& point_m, double radius_m, NearbyLandmarks& nearby) const noexcept {
  nearby.clear();
  const auto along = [this](std::uint16_t landmark) { return place_m(landmark)(axis_); };
  for (auto at = std::ranges::lower_bound(anonymous_, point_m(axis_) - radius_m, {}, along);
       at != anonymous_.end() && along(*at) <= point_m(axis_) + radius_m; ++at)
    if ((place_m(*at) - point_m).norm() <= radius_m && !nearby.try_push_back(*at)) return false;
  return true;
}

}  // namespace ninedot
