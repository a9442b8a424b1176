#pragma once
/// One frame's path: picture -> dots -> landmark -> pose with its uncertainty -> fix. The whole path is in `process`.
#include <chrono>
#include <memory>
#include <optional>

#include "pipeline/frame_processor.h"
#include "pipeline/lens.h"
#include "pipeline/picture_exposure.h"
#include "pipeline/room_map.h"
#include "pipeline/verdict.h"
#include "track/row_time_belief.h"
#include "world/landmark_map.h"

namespace ninedot {

/// Of several landmarks in view the one whose pose is reported (among those that may be acted on, where there are).
enum class MainLandmark : std::uint8_t {
  kNearest,  ///< the founding paper's choice: it changes seldom
  kSurest,   ///< the smallest 1-sigma of the position: a small tilted sheet may be surer than a near frontal one
};

struct LocaliserOptions {
  SeekerOptions seeker{};
  /// From row to row of the camera's shutter, where frames themselves don't tell; 0: all rows at once. None: nobody has
  /// told. RoomLocaliser is uncertain of it then, and learns it from landmarks in different rows; one landmark's shear
  /// looks like a tilt, and Localiser takes it for 0. Both see where pictures contradict what was told.
  std::optional<std::chrono::nanoseconds> row_time{};
  bool learns_row_time = true;  ///< false: what was told, or 0, stands whatever pictures show
  bool tracking = true;         ///< look where the landmark was before searching the whole picture
  TrustLimits trust{};          ///< what is beyond them is found, but not valid
  WorkBudget budget{};          ///< what one frame may cost
  LandmarkMap map{};            ///< Localiser: of one landmark
  /// Where maps come from that take the place of `map` between two frames, of landmarks that the same localiser serves;
  /// null: none comes. Must outlive the localiser.
  RoomMapHandoff* new_maps = nullptr;
  MainLandmark main_landmark = MainLandmark::kNearest;  ///< RoomLocaliser
  /// RoomLocaliser: a pose counts in the world. False: one at a landmark whose place nobody knows is valid as well.
  bool needs_place = true;
  PoseFilterOptions filter{};
  /// [frames] between two searches of the whole picture while landmarks are followed (RoomLocaliser): three searches a
  /// second at 35 frames a second show a sheet that the map does not expect, at a tenth of a search for each frame.
  /// While they do not tell where the camera is, every frame is searched.
  int search_every = 10;
  bool calibrated = true;
  /// What the calibration leaves open about the intrinsics [px^2, px, 1]; none: it does not say, and no sigma knows.
  std::optional<IntrinsicCovariance> intrinsics{};
  /// Of a zoom camera, where its camera model holds [steps]; none: unknown, or it has no zoom.
  std::optional<int> zoom{};
  /// Where the lenses of other positions come from; null: the first one serves all frames. Must outlive the localiser.
  LensExchange* new_lenses = nullptr;
};

/// How much to trust a pose, 0..1000: 1000 * precision * visible * unique, rounded, where
///   precision = 1 / (1 + (sigma / (0.005 D))^2): a half at a 1-sigma of 0.5 % of the distance D, sigma over all axes;
///   visible = dots_used / 9;
///   unique = 1 - ambiguity / 2: a half when the other planar solution fits as well.
std::uint16_t pose_quality(const PoseEstimate& pose) noexcept;

/// Of the camera in the world by the covariance of its pose at one landmark, whose place is taken as exact.
/// \param covariance  PoseEstimate's [m^2, m rad, rad^2] \return  of a PoseStep [m^2, m rad, rad^2]
PoseInformation covariance_in_world(const Matrix6d& covariance,
                                    const Transform<frame::World, frame::Landmark>& T_world_landmark) noexcept;

/// Where there is one black-and-white landmark. Memory: everything is allocated by the constructor. Threads: one
/// caller.
class Localiser final : public FrameProcessor {
 public:
  Localiser(const CameraModel& camera, const LocaliserOptions& options);

  const Fix& process(const Frame& frame) noexcept override;

  const LandmarkObservation* last_observation() const noexcept override {
    return track_.has_sighting() ? &track_.sighting() : nullptr;
  }

  std::optional<FailedSearch> failed_search() const noexcept override;

 private:
  void take_newest_map() noexcept;
  void begin_anew() noexcept;
  const MappedLandmark& mapped() const noexcept { return room_->map.landmarks().front(); }
  void look_at(const Frame& frame) noexcept;
  Result<std::size_t> search(const Frame& frame) noexcept;
  void add_fix(const PoseCandidates& candidates, std::size_t chosen, Reason refused) noexcept;

  void add_calibration_error(LandmarkFix& fix) noexcept;
  void follow_in_world(const Frame& frame, const LandmarkFix& fix) noexcept;
  void learn_row_time(const LandmarkFix& fix, const TrackedPose& tracked) noexcept;

  const LocaliserOptions options_;
  LensInUse lens_;
  std::unique_ptr<RoomMap> room_;
  Track track_;
  PoseFilter filter_;
  RowTimeBelief row_time_;
  PictureExposure exposure_;
  bool is_to_begin_anew_ = false;  // with the next frame: what was followed was so by a wrong row time
  PoseInformation calibration_share_ = PoseInformation::Zero();  // of the newest place in the world
  // What the frame before had no pixels left for: 0 nothing; else the search leaves out the likeliest guess and begins
  // with this one of the less likely.
  std::size_t next_guess_ = 0;
  std::uint32_t frames_cut_ = 0;
  bool has_search_failed_ = false;  // in the last frame
  Fix fix_;
};

}  // namespace ninedot
