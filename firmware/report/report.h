#pragma once
/// What the service knows after one frame, for everything inside this program. What other machines see of it is
/// proto/wire_report.h.
///
/// Plain and trivially copyable; made in one place (pipeline/next_report.h) by the frame loop alone, never changed once
/// it is published. Where several landmarks or several candidates of a pose come, they become lists of fixed capacity
/// in here (base/inline_vector.h).
#include <array>
#include <chrono>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "base/aim_state.h"
#include "base/inline_vector.h"
#include "base/mono_time.h"
#include "base/reason.h"
#include "base/row_time.h"
#include "base/work_counts.h"

namespace ninedot {

/// Which solver answered.
enum class Solver : std::uint8_t { kFull, kEllipse };

/// Camera pose in a named frame: optical centre [m] and the unit quaternion (w, x, y, z; w >= 0) that rotates camera
/// vectors into that frame. Of a body likewise: its origin, its vectors.
struct ReportPose {
  std::array<double, 3> position_m{};
  std::array<double, 4> quaternion_wxyz{1, 0, 0, 0};
};

/// Another reading of the newest frame's landmark.
struct ReportRival {
  double odds = 0;                                                ///< that it is the right one, 0..1; 0: there is none
  ReportPose camera_in_landmark, camera_in_world, body_in_world;  ///< mean something where the odds are above 0
};

/// How far the newest order to the head has come.
enum class OrderProgress : std::uint8_t {
  kNone,     ///< no order since the start
  kRunning,  ///< under way
  kDone,     ///< a set-point: the head stands there; to follow: the head follows
  kFailed,   ///< the head fails, is inhibited, cannot go there, or did not arrive in time
};

/// A landmark in the newest frame that a head may turn to, whether its pose may be acted on or not.
struct ReportSight {
  std::uint16_t id = 0;
  MonoTime exposed_at{};                      ///< middle of that frame's exposure
  std::array<double, 3> landmark_camera_m{};  ///< the middle of its P9 [m], frame camera
};
inline constexpr std::size_t kMostReportSights = 16;

/// The pan/tilt head's part.
struct ReportHead {
  bool present = false;              ///< there is one
  double pan_rad = 0, tilt_rad = 0;  ///< when the frame of a valid pose was exposed, else now; 0 without a head
  bool limited = false;              ///< it stands at an end of its range and should go further
  bool failed = false;               ///< it could not be moved, or does not answer
  bool inhibited = false;            ///< the inhibit input keeps it where it is
  std::uint32_t order = 0;           ///< number of the order that it follows, see aim/aimer.h
  OrderProgress progress = OrderProgress::kNone;
  AimState state = AimState::kNone;  ///< what it is doing

  bool operator==(const ReportHead&) const = default;
};

/// Since the start; all wrap.
struct FrameCounts {
  std::uint32_t processed = 0;  ///< found or not: the heartbeat
  std::uint32_t dropped = 0;    ///< lost between the sensor and the frame loop
  std::uint32_t failed = 0;     ///< arrived, but unreadable or of a wrong size
  WorkCounts work;
};

/// One frame's outcome. While nothing is found the pose, its covariance and `exposed_at` stay those of the last valid
/// one, and `valid` is false: a stale pose never looks fresh.
struct Report {
  FrameCounts frames;
  std::uint32_t pose_sequence = 0;          ///< +1 per valid pose; wraps
  std::uint64_t frame_number = 0;           ///< of the frame this report is about
  bool has_pose = false;                    ///< there has been a valid one: the numbers of the pose mean something
  MonoTime exposed_at{};                    ///< middle of the exposure of the frame that the POSE is from
  MonoTime published_at{};                  ///< when the frame loop published this report
  std::chrono::nanoseconds latency{};       ///< mid-exposure to publish of the last processed frame
  std::chrono::nanoseconds process_time{};  ///< detection and pose alone
  RowTime row_time;                         ///< of the camera's shutter, as the newest frame was taken for

  bool valid = false;       ///< pose is of this very frame and usable
  bool found = false;       ///< the frame shows a landmark
  bool ambiguous = false;   ///< the newest frame's pose is not valid because another reading is too likely
  bool calibrated = false;  ///< a camera calibration was loaded
  bool tracking = false;    ///< found where the track predicted it, without a full search
  Reason reason = Reason::kStarting;
  Solver solver = Solver::kFull;

  std::uint16_t landmark_id = 0;
  std::uint16_t quality = 0;  ///< 0..1000

  ReportPose camera_in_landmark;  ///< frame S0 of the landmark
  ReportPose camera_in_world;     ///< by the map; equals camera_in_landmark without one
  /// Row-major 6x6 of (position in S0 [m], rotation vector in the camera frame [rad]).
  std::array<double, 36> covariance{};
  /// 1-sigma of the position, all axes together, by the camera's calibration alone [m]: part of `covariance`, and of
  /// `covariance_world`. NaN: the calibration does not say how good it is.
  double calibration_sigma_m = std::numeric_limits<double>::quiet_NaN();
  double calibration_sigma_world_m = std::numeric_limits<double>::quiet_NaN();
  std::array<double, 36> covariance_world{};  ///< of camera_in_world, likewise [m^2, m rad, rad^2]
  ReportPose body_in_world;                   ///< as the head stood at the exposure; see geometry/body.h
  std::array<double, 36> covariance_body{};   ///< of body_in_world, likewise [m^2, m rad, rad^2]

  double ambiguity = 0;  ///< odds of all other readings; of the newest frame where that is `ambiguous`. 0..1
  double rms_px = 0;     ///< residual, as PoseEstimate has it [px]
  std::uint16_t dots_used = 0;
  std::uint16_t occlusion_level = 0;
  double swing_psi_rad = 0, tilt_phi_rad = 0, pan_theta_rad = 0;
  double distance_m = 0, image_distance_m = 0, deviation_rad = 0;

  std::uint16_t landmarks_seen = 0;         ///< of the map, in the newest frame
  std::uint16_t landmarks_rejected = 0;     ///< of these: they do not hang where the map says
  std::uint16_t last_rejected_id = 0xFFFF;  ///< in whichever frame; 0xFFFF: none since the start
  /// How many of the map contradict another one, with nothing that says which of them hangs elsewhere; two of them.
  std::uint16_t landmarks_disputed = 0;
  std::array<std::uint16_t, 2> disputed_ids{0xFFFF, 0xFFFF};  ///< 0xFFFF: none

  ReportRival rival;
  InlineVector<ReportSight, kMostReportSights> sights;  ///< for the head to choose from; that of the pose first
  ReportHead head;
};
static_assert(std::is_trivially_copyable_v<Report>);

}  // namespace ninedot
