#pragma once
/// Where the camera is in the world and how it moves, from all pictures up to now.
///
/// Constant velocity with white-noise acceleration (motion_model.h); a picture enters by its rays (pose_mode.h). Where
/// pictures lie further from what was foretold than that allows, as of a robot that brakes harder than the options say,
/// the noise grows until they agree, and falls back with the surprise (adaptive estimation by the innovations: R. K.
/// Mehra, IEEE Trans. Automatic Control 17 (1972) 693-698). While a mirror image or another numbering is open, up to
/// four hypotheses are followed, each weighted by the likelihood of what it foretold (a Gaussian sum: D. L. Alspach,
/// H. W. Sorenson, IEEE Trans. Automatic Control 17 (1972) 439-448).
///
/// It starts with a frame's readings; each that is offered later and is another crest under a hypothesis' prediction
/// becomes one of its own, with what its crest is worth (Laplace's approximation of the posterior's mass there).
/// Hypotheses within each other's covariance become one; those below kLeastWeight are dropped.
///
/// It begins anew, with the readings of the same frame:
/// - after `kMaxGated` frames in a row that it can't believe: no crest under any hypothesis lies within the gate, a
///   chi^2 of six freedoms that one true frame in a million exceeds;
/// - with the first frame after `kMaxSilence` without one that it believed. Until then it goes on by its velocity.
#include <cstdint>
#include <optional>
#include <span>

#include "base/inline_vector.h"
#include "base/mono_time.h"
#include "base/units.h"
#include "track/pose_mode.h"

namespace ninedot {

struct PoseFilterOptions {
  LandmarkGeometry landmark{};
  /// 1-sigma of the accelerations that the robot makes usually, each axis, taken to last for kManoeuvre_s. [m/s^2]
  double acceleration_sigma_m_s2 = 0.3;
  /// Likewise, of its turns and its head's. [rad/s^2]
  double angular_acceleration_sigma_rad_s2 = 60 * kRadPerDeg;
  /// Of the sightings' variance the share that consecutive frames have in common, 0..0.9. In nine rendered ways through
  /// rooms (500 frames, 0.05 to 1.6 m/s, turns of up to 45 degrees per second) the products of neighbouring errors are
  /// 0.1 of their squares, in the median; of a lone sheet at 35 Hz and 10 ms of exposure (69 pairs of frames) 0.76,
  /// 0.60 and 0.47 along x, y and z. This leaves rms of error / sigma at 0.63 to 1.07 in the former and 1.04 in the
  /// latter.
  double common_share = 0.2;
};

/// A place of the camera that would explain a frame.
struct WorldReading {
  WorldFromCamera T_world_camera;
  double chi2_above = 0;  ///< how much worse it explains the frame than the best one, prior odds included [1]
  std::size_t turn = 0;   ///< index of the members' dot that is P1 if this is true; 0: they are numbered rightly [1]
};

/// What became of a frame.
enum class FilterVerdict : std::uint8_t {
  kStarted,  ///< the track begins with it, the first or anew
  kTaken,    ///< it is in the track
  kGated,    ///< not to be believed: the track goes on without it
  kNothing,  ///< it shows nothing, or no reading that is known to 6 % of the distance to begin with
  kTooLate,  ///< not newer than the last one: refused
};

struct TrackedPose {
  MonoTime at{};
  CameraMotion motion{};  ///< of the likeliest hypothesis
  /// About `motion`: its own covariance with what frames have in common, and the other hypotheses with their odds and
  /// their distance (second moment of the mixture about the pose that is given). [m, rad, m/s, rad/s]
  MotionCovariance covariance = MotionCovariance::Zero();
  /// Odds of the hypotheses that lie elsewhere, outside of its own covariance (95 % of six freedoms), 0..1. Above
  /// pose.max_ambiguity a pose is not valid, however large its covariance.
  double ambiguity = 0;
  int gated_frames = 0;  ///< the newest frames in a row that were not believed: above 0 it is in doubt, and not valid
  double misfit = 1;     ///< squared, of the rays against their stated sigma, over the last second; 1 or more [1]
};

/// Memory: none beyond itself. Threads: one caller.
class PoseFilter {
 public:
  static constexpr std::size_t kMaxModes = 4;
  static constexpr std::size_t kMaxReadings = 8;  ///< of a frame; further ones are not looked at
  static constexpr double kManoeuvre_s = 0.25;
  static constexpr int kMaxGated = 5;
  static constexpr std::chrono::nanoseconds kMaxSilence = std::chrono::seconds(1);
  static constexpr double kLeastWeight = 1e-5;

  explicit PoseFilter(const PoseFilterOptions& options) noexcept;

  /// \param members  the sightings that are believed to be landmarks of the map, each with its landmark's place
  /// \param readings  the frame's, best first; needed at the start and for further crests, none if nothing is open
  FilterVerdict take(MonoTime exposed_at, std::span<const JointMember> members,
                     std::span<const WorldReading> readings) noexcept;

  /// None: it has not begun, `time` lies before the newest frame that it was given, or kMaxSilence after the last that
  /// it believed.
  std::optional<TrackedPose> at(MonoTime time) const noexcept;

  /// The likeliest hypothesis alone, for who looks for its landmarks in the next frame: covariance of the pose with
  /// what frames have in common. No measurement: who made a frame's pose with it must not bring it back as another.
  struct Forecast {
    WorldFromCamera T_world_camera;
    PoseInformation covariance;  ///< of PoseSteps [m^2, m rad, rad^2]
    double ambiguity;            ///< odds that another hypothesis is the right one, 0..1
  };
  std::optional<Forecast> forecast(MonoTime time) const noexcept;  ///< none: as at()

  void reset() noexcept;  ///< forgets where the camera is; not how suddenly it moves

 private:
  struct Child {
    Crest crest;
    std::size_t parent = 0;  // index in Parents
    double log_motion = 0, log_picture = 0;
    double log_weight() const noexcept { return log_motion + log_picture; }
  };
  using Parents = InlineVector<PoseMode, 2 * kMaxModes>;
  using Children = InlineVector<Child, 2 * kMaxModes*(1 + kMaxReadings)>;

  ErrorShares shares() const noexcept;
  bool can_answer(MonoTime time) const noexcept;
  FilterVerdict start(MonoTime exposed_at, const FrameView& frame, std::span<const WorldReading> readings) noexcept;
  Parents parents_for(const FrameView& frame) const noexcept;
  void find_crests(const FrameView& frame, std::span<const WorldReading> readings, const Parents& parents,
                   Children& children) const noexcept;
  void follow(Children& children, const Parents& parents) noexcept;
  void note_fit(const Crest& crest) noexcept;
  void note_surprise(double chi2) noexcept;
  MotionNoise noise() const noexcept;
  void tidy() noexcept;

  PoseFilterOptions options_;
  MotionNoise noise_;
  InlineVector<PoseMode, kMaxModes> modes_;  // likeliest first; weights sum to 1
  MonoTime newest_at_{}, believed_at_{};     // of modes_; of the last frame that entered
  bool has_frame_ = false;
  int gated_ = 0;
  double misfit_ = 1;
  // By how much the motion's noise is above that of the options. The robot's, whatever track there is: one that begins
  // anew keeps it. [1]
  double unrest_ = 1;
};

}  // namespace ninedot
