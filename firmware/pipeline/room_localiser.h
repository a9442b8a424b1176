#pragma once
/// One frame's path where a map names several landmarks, or coded ones: each landmark in view is followed, new ones are
/// looked for where the map lets expect them and, now and then, everywhere; colours tell which ones they are; all
/// together place the camera in the world. The whole path is in `process`.
#include <cstdint>
#include <memory>

#include "pipeline/localiser.h"
#include "pipeline/room_map.h"
#include "pipeline/smeared_view.h"
#include "track/world_track.h"

namespace ninedot {

/// Memory: everything is allocated by the constructor. Threads: one caller.
class RoomLocaliser final : public FrameProcessor {
 public:
  /// Landmarks in view beyond kMaxLandmarksInView are not followed.
  RoomLocaliser(const CameraModel& camera, const LocaliserOptions& options);

  const Fix& process(const Frame& frame) noexcept override;
  const LandmarkObservation* last_observation() const noexcept override;
  std::optional<FailedSearch> failed_search() const noexcept override;

 private:
  /// A landmark in view.
  struct InView {
    Track track{TrackOptions{}};
    PoseCandidates candidates;  ///< of the frame under way, with its track's odds
    std::size_t chosen = 0;     ///< index of the one that is believed [1]
    RowMotion row_motion;       ///< that they were found with
    std::optional<Identity> identity;
    std::optional<std::size_t> expected;  ///< who should be there, by the map and the camera's track [1]
    ShownColours colours;
    double doubt = 0;                   ///< of its identity, since it is known: see CodeIdentity::is_still [1]
    bool is_fresh = true;               ///< it came into view in this frame
    bool fits_black_and_white = false;  ///< when it was last detected: see LandmarkSeeker
    bool is_followed = false;           ///< its outlines were where its track foretold them: it is the same sheet

    /// It may be another sheet than it was taken for.
    void forget_identity() noexcept {
      identity.reset();
      expected.reset();
      colours = {};
      doubt = 0;
    }
  };

  void take_newest_map() noexcept;
  void begin_anew() noexcept;
  void look_at(const Frame& frame) noexcept;
  std::optional<CameraTwist> twist_at(MonoTime time) const noexcept;
  void take_found(InView& landmark, std::size_t chosen) const noexcept;
  void follow(const Frame& frame) noexcept;
  void look_where_expected(const Frame& frame) noexcept;
  bool begin_where_expected(const Frame& frame, const CameraFromLandmark& T_camera_landmark,
                            std::size_t map_index) noexcept;
  void look_everywhere(const Frame& frame) noexcept;
  bool begin_to_follow(const LandmarkObservation& seen) noexcept;
  bool go_on_elsewhere(const LandmarkObservation& seen) noexcept;
  bool any_identified() const noexcept;
  void identify(const Frame& frame) noexcept;
  void number_by_code(const Frame& frame, InView& landmark) noexcept;
  WorldVerdict place_in_world(const Frame& frame) noexcept;
  void report_world(const WorldPose& world, std::span<const SightedLandmark> sighted,
                    std::span<const std::size_t> which) noexcept;
  void tell_disputes() noexcept;
  void add_calibration_error(WorldPose& world) noexcept;
  void learn_row_time(const WorldPose& world, std::span<const SightedLandmark> sighted,
                      std::span<const std::size_t> which) noexcept;
  void note_carriers() noexcept;
  void believe_world(InView& landmark, std::size_t map_index, std::size_t turn, const WorldPose& world) noexcept;
  void add_fix(const InView& landmark, std::size_t map_index, const SightingVerdict& verdict,
               const WorldPose& world) noexcept;
  InView* in_view_at(const Eigen::Matrix3d& H_ray_plane) noexcept;
  static bool is_stranger(const InView& landmark) noexcept;

  const LocaliserOptions options_;
  LensInUse lens_;
  std::unique_ptr<RoomMap> room_;
  WorldTrack track_;
  RowTimeBelief row_time_;
  bool is_to_begin_anew_ = false;  // with the next frame: what was followed was so by a wrong row time
  PoseInformation calibration_share_ = PoseInformation::Zero();  // of the newest place in the world
  InlineVector<InView, kMaxLandmarksInView> in_view_;
  InlineVector<InView, kMaxLandmarksInView> lost_;  ///< in view in the frame before, and not where they should be
  SmearedView smeared_;
  int frames_since_search_ = 0;
  std::uint32_t frames_cut_ = 0;
  bool has_search_failed_ = false;  ///< in the last frame
  Fix fix_;
};

}  // namespace ninedot
