#pragma once
/// The map's landmarks as the world solver takes them, with what it looks up prepared.
#include <cstdint>
#include <span>
#include <vector>

#include "base/inline_vector.h"
#include "world/landmark_map.h"
#include "world/place_uncertainty.h"

namespace ninedot {

/// A landmark of the map.
struct PlacedLandmark {
  WorldFromLandmark T_world_landmark;
  PoseCovariance covariance = PoseCovariance::Zero();  ///< of the place [m^2, m rad, rad^2]
  bool has_place = true;                               ///< false: it takes no part
  bool is_black_and_white = true;

  /// Its P1 is its lowest dot, to 20 degrees: less than half of an eighth of a turn.
  bool is_upright() const noexcept { return T_world_landmark.rotation(2, 2) > 0.94; }
};

/// The landmarks of a map, in its order.
std::vector<PlacedLandmark> placed_landmarks(const LandmarkMap& map);

/// Two landmarks, named by their index [1].
struct LandmarkPair {
  float distance_m;  ///< between their P9
  std::uint16_t first, second;
};

/// Indices of landmarks [1].
using NearbyLandmarks = InlineVector<std::uint16_t, 16>;

/// Memory: all at construction: 8 bytes for each pair, 4 MB at most. Threads: const is safe.
class PreparedMap {
 public:
  /// \param landmarks  at most LandmarkMap::kCapacity (contract)
  explicit PreparedMap(std::vector<PlacedLandmark> landmarks);

  std::span<const PlacedLandmark> landmarks() const noexcept { return landmarks_; }
  const PlacedLandmark& operator[](std::size_t landmark) const noexcept { return landmarks_[landmark]; }

  // Of the black-and-white ones that have a place:

  /// Indices.
  std::span<const std::uint16_t> anonymous() const noexcept { return anonymous_; }
  /// All pairs of them, the nearest first, that one picture can hold: no further apart than kFarthestPair_m.
  std::span<const LandmarkPair> pairs() const noexcept { return pairs_; }
  /// Those pairs whose distance is within [least_m, most_m].
  std::span<const LandmarkPair> pairs_at(double least_m, double most_m) const noexcept;
  /// Those within a radius of a point. \param point_m  world [m] \param nearby  is filled with indices [1]
  /// \return  false: there are more than it has room for
  bool find_nearby(const Eigen::Vector3d& point_m, double radius_m, NearbyLandmarks& nearby) const noexcept;
  /// 1-sigma of the least certain place, all axes together.
  double worst_place_sigma_m() const noexcept { return worst_place_sigma_m_; }

  /// Twice the distance at which a landmark of the default size is still found (docs/accuracy.md: 6 m).
  static constexpr double kFarthestPair_m = 12;

 private:
  const Eigen::Vector3d& place_m(std::size_t landmark) const noexcept {
    return landmarks_[landmark].T_world_landmark.translation_m;
  }

  std::vector<PlacedLandmark> landmarks_;
  std::vector<std::uint16_t> anonymous_;  // along the axis in which they are spread most
  std::vector<LandmarkPair> pairs_;
  Eigen::Index axis_ = 0;
  double worst_place_sigma_m_ = 0;
};

}  // namespace ninedot
