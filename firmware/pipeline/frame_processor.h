#pragma once
/// What the frame loop does with each frame.
#include <array>
#include <chrono>
#include <cstdint>
#include <limits>
#include <optional>

#include "base/inline_vector.h"
#include "base/row_time.h"
#include "detect/failed_search.h"
#include "detect/observation.h"
#include "image/frame.h"
#include "pipeline/sighting_uncertainty.h"
#include "pose/estimate.h"
#include "report/report.h"
#include "track/pose_filter.h"
#include "world/sighting_fit.h"

namespace ninedot {

/// What one frame says of one landmark.
struct LandmarkFix {
  std::uint16_t id = 0;
  PoseCandidates candidates;                                   ///< every reading, with its odds
  std::size_t chosen = 0;                                      ///< index of the one that is believed
  Transform<frame::World, frame::Camera> T_world_camera;       ///< by the map
  PoseInformation covariance_world = PoseInformation::Zero();  ///< of a PoseStep of it [m^2, m rad, rad^2]
  /// What of the position's 1-sigma, all axes together, is the calibration's: of `pose()`, of `covariance_world`. [m]
  /// NaN: it does not say how good it is.
  double calibration_sigma_m = std::numeric_limits<double>::quiet_NaN();
  double calibration_sigma_world_m = std::numeric_limits<double>::quiet_NaN();
  Reason verdict = Reason::kNone;  ///< kNone: it may be acted on; else why not
  bool place_is_sure = false;      ///< a head may turn to it, see is_place_sure
  std::uint16_t quality = 0;       ///< 0..1000, see pose_quality
  LandmarkSighting sighting;       ///< what joins it with others and with other pictures
  RowMotion row_motion;            ///< that the sighting was taken to the middle row with

  /// Of the camera in the frame of this landmark.
  const PoseEstimate& pose() const noexcept { return candidates.list[chosen].pose; }
};

/// Where the camera is in the world, by all landmarks of a frame that have a place there.
struct WorldFix {
  WorldFromCamera T_world_camera;
  PoseInformation covariance = PoseInformation::Zero();   ///< of a PoseStep [m^2, m rad, rad^2]
  double ambiguity = 0;                                   ///< odds of all other places, 0..1
  InlineVector<std::uint16_t, kMaxLandmarksInView> used;  ///< ids of the map
};

/// What one frame says of where the camera is. Says nothing of the frames before it.
struct Fix {
  Reason reason = Reason::kNoLandmark;  ///< kNone: there is a landmark whose pose may be acted on
  bool found = false;                   ///< the frame shows a landmark
  bool tracked = false;                 ///< it was where it was expected
  bool calibrated = false;              ///< the camera's calibration was loaded
  Solver solver = Solver::kFull;
  /// The landmarks that gave a pose, to be acted on or not, the one that counts first.
  InlineVector<LandmarkFix, kMaxLandmarksInView> landmarks;
  /// Ids of those in view that do not hang where the map says: found so in this frame, or before, whether `world` is
  /// there or not.
  InlineVector<std::uint16_t, kMaxLandmarksInView> rejected;
  /// Ids of those of the map, in view or not, that contradict each other, with nothing that says which of them hangs
  /// elsewhere; more than these are not told.
  InlineVector<std::uint16_t, kMaxLandmarksInView> disputed;
  std::optional<WorldFix> world;  ///< none: not valid, or no landmark in view has a place in the world
  /// Of all other places of the camera together, where `world` is not there because they are too likely; else 0. [1]
  double odds_of_other_places = 0;
  std::optional<TrackedPose> track;  ///< by this and all frames before; none: nothing is known of it any more
  RowTime row_time;                  ///< that the frame's rows were taken for
  std::chrono::nanoseconds process_time{};
  WorkCounts work;  ///< of all frames since the start, whatever `reason` says

  /// \pre there is one (contract)
  const LandmarkFix& main() const noexcept { return landmarks[0]; }
};

class FrameProcessor {
 public:
  virtual ~FrameProcessor() = default;
  /// \return  valid until the next call. Memory: none. Threads: one caller.
  virtual const Fix& process(const Frame& frame) noexcept = 0;

  /// A landmark of the last frame, for overlays; null when it showed none. Where its outlines alone were followed it
  /// says so (LandmarkObservation::from_pose).
  virtual const LandmarkObservation* last_observation() const noexcept { return nullptr; }

  /// What there was to see in the last frame, where all of it was searched and nothing found that `Fix::landmarks`
  /// could tell; none: otherwise. Valid until the next frame.
  virtual std::optional<FailedSearch> failed_search() const noexcept { return std::nullopt; }
};

}  // namespace ninedot
