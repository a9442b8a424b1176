#pragma once
/// The sightings of one picture beside the map's landmarks: what all hypotheses about the camera's place look at.
#include <array>
#include <cmath>
#include <span>

#include "world/joint_fit.h"
#include "world/moved_landmarks.h"
#include "world/prepared_map.h"
#include "world/world_pose.h"

namespace ninedot {

struct WorldOptions {
  /// A sighting disagrees above this chi^2 of six freedoms: one in 10,000 true ones does (chi^2 tables). [1]
  double max_disagreement_chi2 = 27.856;
  /// What no model explains, added to a sighting's uncertainty where it is asked whether it agrees, and only there:
  /// print scale and flatness of a sheet and the lens's calibration, as a share of the landmark's distance [1], and as
  /// a tilt [rad]. A print that is 0.1 mm too large over the ring's 160 mm is 0.06 %; 0.1 degrees is 0.3 mm from edge
  /// to edge of the sheet.
  double unexplained_share = 0.5e-3;
  double unexplained_tilt_rad = 1.75e-3;
  double max_ambiguity = 0.01;  ///< above it the pose is not valid
};

/// Which landmark a sighting is taken for: indices [1].
struct Choice {
  static constexpr std::size_t kNone = ~std::size_t{0};
  std::size_t landmark = kNone;  ///< index into the map's landmarks()
  std::size_t turn = 0;          ///< index of the sighting's dot that is P1

  bool is_made() const noexcept { return landmark != kNone; }
};

/// What a sighting says alone.
struct OwnFit {
  CameraFromLandmark T_camera_landmark;  ///< best for its rays
  double chi2 = 0;                       ///< there [1]
  PoseInformation normal;  ///< of a step of the camera in the landmark's frame [1/m^2, 1/(m rad), 1/rad^2]
  double sureness = 0;     ///< logarithm of the determinant of `normal`; -infinity: it determines no pose [1]
};

/// Sightings and landmarks are named by their index [1].
/// Memory: none. Threads: const is safe.
class Scene {
 public:
  /// Fits each sighting alone. All references must outlive it.
  Scene(std::span<const SightedLandmark> seen, const PreparedMap& map, const MovedLandmarks& moved,
        const LandmarkGeometry& landmark, const WorldOptions& options, const WorldPrior* prior) noexcept;

  std::span<const SightedLandmark> seen() const noexcept { return seen_; }
  const PreparedMap& map() const noexcept { return map_; }
  const LandmarkGeometry& landmark() const noexcept { return landmark_; }
  const WorldOptions& options() const noexcept { return options_; }
  const WorldPrior* prior() const noexcept { return prior_; }  ///< null: none

  const OwnFit& own(std::size_t sighting) const noexcept { return own_[sighting]; }
  /// Indices of the sightings that determine a pose, the surest first.
  std::span<const std::size_t> by_sureness() const noexcept { return by_sureness_.span(); }

  /// Its rays alone say where the camera is before it.
  bool determines_pose(std::size_t sighting) const noexcept { return std::isfinite(own_[sighting].sureness); }
  /// Coded, in the map, and not found moved: it has a say in where the camera is.
  bool is_known(std::size_t sighting) const noexcept;
  /// Coded, in the map, and found moved.
  bool is_known_moved(std::size_t sighting) const noexcept;
  /// Black and white, and there is one in the map that it could be.
  bool is_anonymous(std::size_t sighting) const noexcept;
  /// Not found moved.
  bool is_believed(std::size_t landmark) const noexcept { return !moved_.is_moved(landmark); }
  /// It contradicted another one, and nobody knows which of them was moved.
  bool is_disputed(std::size_t landmark) const noexcept { return moved_.is_disputed(landmark); }
  /// What a hypothesis pays for leaving it out [1].
  double leave_out_cost(std::size_t sighting) const noexcept { return leave_out_cost_[sighting]; }
  /// What speaks against a coded sighting's meeting by chance the place that a prior foretells [1]: the more, the
  /// better that is known.
  double cost_of_chance(std::size_t sighting, const WorldPrior& prior) const noexcept;
  /// What speaks against this numbering of a black-and-white sighting's dots [1].
  double numbering_cost(std::size_t sighting, const Choice& choice) const noexcept;

  JointMember member(std::size_t sighting, const Choice& choice) const noexcept;
  /// Where the camera is if this sighting alone says so. \param T_camera_landmark  one of its crests
  WorldFromCamera camera_by(const CameraFromLandmark& T_camera_landmark, const Choice& choice) const noexcept;

 private:
  double cost_of_leaving_out(std::size_t sighting) const noexcept;

  std::span<const SightedLandmark> seen_;
  const PreparedMap& map_;
  const MovedLandmarks& moved_;
  const LandmarkGeometry& landmark_;
  const WorldOptions& options_;
  const WorldPrior* prior_;
  std::array<OwnFit, kMaxSightings> own_;
  std::array<double, kMaxSightings> leave_out_cost_{};
  InlineVector<std::size_t, kMaxSightings> by_sureness_;
};

/// The sheet's axes as numbered by a sighting whose dot at index `turn` is P1, from the printed ones: a turn in the
/// sheet's plane. \return  rotation matrix [1] \param turn  index [1]
Eigen::Matrix3d axes_of_turn(std::size_t turn) noexcept;

}  // namespace ninedot
