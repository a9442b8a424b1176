#pragma once
/// Which landmarks there are, and where they hang in the world.
#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "geometry/transform.h"

namespace ninedot {

struct MappedLandmark {
  std::uint16_t id = 0;
  std::string code;                                           ///< P1..P8, eight of K R G B; empty: black and white
  Transform<frame::World, frame::Landmark> T_world_landmark;  ///< the identity where has_place is false
  bool has_place = true;                                      ///< false: nobody knows yet where it hangs
  /// Of its place, (position [m], rotation vector [rad]) both in the world's axes: p + position, exp(rotation) R. [m^2,
  /// m rad, rad^2] Zero: exact.
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  bool from_pictures = false;  ///< its place was not measured but follows from pictures, see `ninedot map`
};

/// Memory: made at the start, constant afterwards. Threads: const is safe.
class LandmarkMap {
 public:
  static constexpr std::size_t kCapacity = 1000;  ///< beyond it the configuration's check refuses

  /// One black-and-white landmark, id 0, at the world's origin.
  LandmarkMap() : landmarks_(1) {}
  /// \param landmarks  at least one, at most kCapacity, every id once (contract)
  explicit LandmarkMap(std::vector<MappedLandmark> landmarks);

  std::span<const MappedLandmark> landmarks() const noexcept { return landmarks_; }
  /// Null: no landmark of this id. Binary search.
  const MappedLandmark* find(std::uint16_t id) const noexcept;

 private:
  std::vector<MappedLandmark> landmarks_;  // by id
};

/// The place of a landmark that hangs upright: its P9 at `position_m` [m, world], turned by `heading_rad` about the
/// world's Z (positive from X towards Y). Heading 0: the axes of S0 are those of the world, the sheet looks along +Y.
/// Memory: none. Threads: pure.
Transform<frame::World, frame::Landmark> place_upright(const Eigen::Vector3d& position_m, double heading_rad) noexcept;

/// The heading of a sheet's X axis about the world's Z, -pi..pi [rad]: for one that hangs upright, that which
/// place_upright was given. Memory: none. Threads: pure.
double heading_rad(const Transform<frame::World, frame::Landmark>& place) noexcept;
/// By how much it would have to be turned to hang upright with that heading, 0..pi [rad]. Memory: none. Threads: pure.
double lean_rad(const Transform<frame::World, frame::Landmark>& place) noexcept;

}  // namespace ninedot
