#pragma once
/// All that lasts of a landmark from one frame to the next: where it is and how it moves, in all six freedoms; which of
/// its readings is believed, and what the losers' odds are; and what its outlines say of the camera and the sheet.
#include <array>
#include <optional>

#include "base/mono_time.h"
#include "detect/forecast.h"
#include "detect/observation.h"
#include "geometry/upright_prior.h"
#include "pose/estimate.h"
#include "pose/full_solver.h"

namespace ninedot {

/// Whether a pose may be published: every number finite, every variance above zero. A covariance of zero would claim a
/// certainty that no camera has.
bool is_publishable(const PoseEstimate& pose) noexcept;

struct TrackOptions {
  double focal_px = 720;  ///< of the camera
  LandmarkGeometry landmark{};
  bool pose_foretells = true;  ///< poses are good enough to say where the outlines will be; else what was seen says it
  UprightPrior upright{};      ///< how the camera is mounted
};

/// How a landmark moves before the camera, by what its track has seen.
struct MeasuredMotion {
  SheetMotion sheet;       ///< rows all at once
  double noise_rad_s = 0;  ///< of its direction's speed, 1-sigma, each axis: what the noise of its poses makes of it
  double over_s = 0;       ///< from the pose before to the newest
  /// By how much its direction gains speed, and how much of that is new [1/s^2]; none: two poses do not tell.
  struct Gain {
    Eigen::Vector2d acceleration_1_s2, change_1_s2;
  };
  std::optional<Gain> gain;
};

/// Memory: none. Threads: one caller.
class Track {
 public:
  explicit Track(const TrackOptions& options) noexcept : options_(options) {}

  /// The frame before showed the landmark; with a pose, or as dots alone.
  bool has_sighting() const noexcept { return has_sighting_; }
  const LandmarkObservation& sighting() const noexcept { return sighting_; }
  /// What the solver may start from; null: the frame before gave no pose.
  const PosePrior* prior() const noexcept { return has_pose_ ? &prior_ : nullptr; }
  /// The sheet before the camera, if it goes on as over the last frames: turning and moving as between the last two,
  /// its direction gaining speed as it has. \pre prior() (contract)
  CameraFromLandmark expected_at(MonoTime time) const noexcept;

  /// How it moves then, if it goes on as expected_at() says; rows all at once. None: the last two frames did not both
  /// have a pose.
  std::optional<SheetMotion> motion_at(MonoTime time) const noexcept;

  /// How it moved while the frame was exposed that was taken last: by its pose and those of the two frames before.
  /// None: the frame before gave no pose.
  std::optional<MeasuredMotion> motion_now() const noexcept;

  /// How it moves if this is where it is now: across the view, as between the frame before and this one.
  /// \param ray  to the sheet's middle, z = 1 \return  rows all at once; none: the frame before gave no pose
  std::optional<SheetMotion> motion_across(const Eigen::Vector2d& ray, MonoTime time) const noexcept;

  /// Who knows how the camera moves says how the sheet does: its turning, which one landmark shows poorly, and its way
  /// where the last two frames did not both have a pose. Until the next pose.
  void foretell(const SheetMotion& motion) noexcept;

  /// Where to look for it. \pre has_sighting() (contract)
  LandmarkForecast forecast(MonoTime time) const noexcept;
  /// Where it was last, for the numbers of its dots: a landmark that was out of sight for a moment has not been turned
  /// by an eighth meanwhile. None: nothing is remembered, or it is too long ago.
  std::optional<LandmarkForecast> remembered(MonoTime time) const noexcept;

  /// Its motion is foretold so well that its outlines may be looked for at once.
  bool may_follow_outlines() const noexcept;
  /// What a pose found by following outlines is like if it is what the track is after. \pre prior() (contract)
  PoseExpectation expectation(MonoTime exposed_at) const noexcept;

  /// The frame shows the landmark, whatever comes of it.
  void see(const LandmarkObservation& seen) noexcept;
  /// Chooses one of the readings: by the picture, and where it can't tell by continuity. What the losers are worth
  /// stays in its `ambiguity`, the likeliest of them in `rival`. \return  index of the chosen one \error
  /// kPoseDegenerate: its numbers are not finite; the track has no pose then
  Result<std::size_t> take(PoseCandidates& candidates, MonoTime exposed_at) noexcept;
  /// What was taken last was another one of its readings: more than this landmark's picture says so. \param chosen
  /// index of it [1]
  void believe(PoseCandidates& candidates, std::size_t chosen) noexcept;
  /// The landmark is not where it was, and is looked for everywhere: where it is found is no motion.
  void jump() noexcept;
  /// The frame gave no pose. \param sighted  but it shows the landmark
  void lose_pose(bool sighted) noexcept;

  /// Which dot is P1 is known from now on, by the dots' colours: whatever the camera's roll, no other numbering is
  /// possible. Until `reset`.
  void know_numbering() noexcept { numbering_is_known_ = true; }

  /// Another numbering of the dots has become so much likelier over the track's whole way that it must begin anew: a
  /// camera that would have to lie on its side was numbered wrongly when the track began.
  bool is_numbering_refuted() const noexcept;
  /// Forgets everything.
  void reset() noexcept;

 private:
  /// Per second, in the camera frame.
  struct Motion {
    Eigen::Vector3d rotation_rad_s = Eigen::Vector3d::Zero(), translation_m_s = Eigen::Vector3d::Zero();
    double over_s = 0;  ///< between which poses; 0: it was foretold
    bool is_own() const noexcept { return over_s > 0; }
    Eigen::Vector2d acceleration_1_s2 =
        Eigen::Vector2d::Zero();                        ///< of its ray (x/z, y/z): a camera that begins to turn
    Eigen::Vector3d now_m_s = Eigen::Vector3d::Zero();  ///< translation at the later one; the other is their middle's
    std::optional<MeasuredMotion::Gain> gain = {};      ///< likewise
    double ray_sigma_1 = 0;                             ///< of its direction in one frame
  };
  std::size_t choose(const PoseCandidates& candidates) const noexcept;
  double rows_after_middle_s(const CameraFromLandmark& T, const SheetMotion& motion) const noexcept;
  CameraFromLandmark note_motion(const PoseCandidate& fitted, MonoTime exposed_at) noexcept;
  void note_numbering() noexcept;

  TrackOptions options_;
  bool has_sighting_ = false;  // sighting_ is of the frame before
  LandmarkObservation sighting_;

  bool has_pose_ = false;  // all below is of the frame before
  PosePrior prior_;
  PoseEstimate pose_;
  MonoTime pose_at_{};
  std::optional<Motion> motion_;  // between the last two frames, if both had a pose
  double surprise_px_ = 0;        // how far the landmark was from where it was expected
  bool has_jumped_ = false;       // it had a pose, and was not where that let expect it
  double mirror_weight_ = 0;      // of the mirror image when it was, see reading_odds.h

  /// What speaks against each numbering, k eighths from the one believed: the worst that upright_costs said of it since
  /// the track began. The worst and not the sum: a camera that stands askew for an hour says it once.
  NumberingCosts numbering_worst_{};
  bool numbering_is_known_ = false;
  bool has_past_ = false;  // numbering_worst_, prior_ and pose_at_ are of this track, if it is out of sight
};

}  // namespace ninedot
