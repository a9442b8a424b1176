#pragma once
/// What is asked of the world solver, and what it answers.
#include <cstddef>
#include <cstdint>
#include <optional>

#include "base/inline_vector.h"
#include "geometry/upright_prior.h"
#include "world/joint_fit.h"

namespace ninedot {

/// One landmark in view, and what is known of which one it is.
struct SightedLandmark {
  LandmarkSighting sighting;
  /// The other planar solution, where the picture does not exclude it; how much worse it explains the picture:
  /// difference of chi^2.
  std::optional<CameraFromLandmark> mirror;
  double mirror_chi2_above = 0;  ///< [1]
  /// Coded: index into the map's landmarks(), the dots numbered by the code. None: black and white, it may be each
  /// black-and-white landmark of the map, in each of eight numberings.
  std::optional<std::size_t> coded;
  double others_odds = 0;            ///< coded: that it is another one, or none, 0..1
  NumberingCosts numbering_costs{};  ///< black and white: against the dot at index k being P1 [1]
  /// Its dots run into each other: where it disagrees it is left out, but that rather speaks against its fit than
  /// against the map.
  bool is_smeared = false;
};

/// Where a track expects the camera.
///
/// A track that has stood on one landmark alone of late is no witness for it: it goes where that one takes it. While it
/// is in view, what decides between it and those that contradict it is what was known before.
struct WorldPrior {
  WorldFromCamera T_world_camera;
  PoseCovariance covariance = PoseCovariance::Zero();  ///< of a PoseStep [m^2, m rad, rad^2]
  /// Odds that the camera is elsewhere altogether, 0..1: a track whose own readings are open decides no more than that.
  double ambiguity = 0;
  std::optional<std::size_t> stands_on = {};  ///< index into the map's landmarks(); none: it stands on several
  std::optional<std::size_t> doubted = {};    ///< index of a sighting that contradicted it before, and so still does
  const WorldPrior* without = nullptr;        ///< without that one; null: nothing is known then
};

/// Whether a pose in the world may be acted on.
enum class WorldVerdict : std::uint8_t {
  kValid,
  kNothingSeen,   ///< no landmark with a place in the map
  kOnlyMoved,     ///< none but landmarks that were found moved
  kAmbiguous,     ///< another place of the camera is too likely; or the landmarks contradict each other, and no track
                  ///< decides
  kUndetermined,  ///< the dots that are seen determine no pose
};

enum class SightingUse : std::uint8_t {
  kUsed,           ///< the pose is made of it
  kRejected,       ///< its landmark does not hang where the map says
  kNotIdentified,  ///< no landmark of the map explains it, or several do
  kNoPlace,        ///< its landmark has no place in the map
  kMisread,        ///< its landmark hangs where the map says, and another of its dots is P1 than its colours said
};

/// What became of one sighting; indices and chi^2 [1].
struct SightingVerdict {
  SightingUse use = SightingUse::kNotIdentified;
  std::optional<std::size_t> landmark;  ///< index into the map's landmarks()
  std::size_t turn = 0;                 ///< index of the sighting's dot that is P1
  /// Against the pose that all others that are used give: chi^2 of six freedoms, both uncertainties counted. 0 where
  /// there are no others. [1]
  double chi2_against_rest = 0;
};

struct WorldPose {
  WorldVerdict verdict = WorldVerdict::kNothingSeen;
  WorldFromCamera T_world_camera;                          ///< the likeliest, valid or not; identity: none
  PoseCovariance covariance = PoseCovariance::Zero();      ///< of a PoseStep [m^2, m rad, rad^2]
  double ambiguity = 1;                                    ///< odds of all other places of the camera together, 0..1
  InlineVector<SightingVerdict, kMaxSightings> sightings;  ///< in the order in which they were given
  bool agrees_with_prior = true;                           ///< false: there was one, and the landmarks outvoted it
  bool is_contested = false;  ///< it stands on one landmark that is in view: see WorldPrior
  double astray = 0;          ///< odds that the prior is right, and all that is seen hangs elsewhere, 0..1; 0: no prior

  bool is_valid() const noexcept { return verdict == WorldVerdict::kValid; }
  std::size_t count(SightingUse use) const noexcept {
    std::size_t n = 0;
    for (const SightingVerdict& sighting : sightings) n += sighting.use == use ? 1U : 0U;
    return n;
  }
};

}  // namespace ninedot
