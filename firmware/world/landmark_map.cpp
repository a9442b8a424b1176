#include "world/landmark_map.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "base/contract.h"

namespace ninedot {

LandmarkMap::LandmarkMap(std::vector<MappedLandmark> landmarks) : landmarks_(std::move(landmarks)) {
  EXPECTS(!landmarks_.empty() && landmarks_.size() <= kCapacity);
  std::ranges::sort(landmarks_, {}, &MappedLandmark::id);
  EXPECTS(std::ranges::adjacent_find(landmarks_, {}, &MappedLandmark::id) == landmarks_.end());
}

const MappedLandmark* LandmarkMap::find(std::uint16_t id) const noexcept {
  const auto at = std::ranges::lower_bound(landmarks_, id, {}, &MappedLandmark::id);
  return at != landmarks_.end() && at->id == id ? &*at : nullptr;
}

Transform<frame::World, frame::Landmark> place_upright(const Eigen::Vector3d& position_m, double heading_rad) noexcept {
  return {exp_so3(heading_rad * Eigen::Vector3d::UnitZ()), position_m};
}

double heading_rad(const Transform<frame::World, frame::Landmark>& place) noexcept {
  return std::atan2(place.rotation(1, 0), place.rotation(0, 0));
}

double lean_rad(const Transform<frame::World, frame::Landmark>& place) noexcept {
  const Eigen::Matrix3d upright = place_upright(place.translation_m, heading_rad(place)).rotation;
  return Eigen::AngleAxisd(Eigen::Matrix3d(upright.transpose() * place.rotation)).angle();
}

}  // namespace ninedot
