#pragma once
/// What one frame yields, for everybody who asks: registers, CSV, status. Plain numbers, trivially copyable.
#include <array>
#include <cstdint>
#include <type_traits>

#include "base/mono_time.h"

namespace ninedot {

/// Why a report is not valid. The numbers are register values: never renumber, only append.
enum class Reason : std::uint16_t {
  kNone = 0,             ///< the pose is valid
  kStarting = 1,         ///< no frame has been processed yet
  kNoLandmark = 2,       ///< the frame shows no landmark
  kPoseDegenerate = 3,   ///< a landmark was seen, but what is visible does not determine a pose
  kCameraLost = 4,       ///< the camera vanished or stalled
  kFrameSize = 5,        ///< the frame's size is not the calibration's
  kFrameUnreadable = 6,  ///< the picture could not be read
  kStopped = 7,          ///< the source is over (a recording that does not loop)
  kStale = 8,  ///< the newest report is valid but too old; set where a report is read, never by the frame loop
};

/// Which solver answered.
enum class Solver : std::uint16_t { kFull = 0, kEllipse = 1 };

/// Camera pose in a named frame: optical centre [m] and the unit quaternion (w, x, y, z; w >= 0) that rotates camera
/// vectors into that frame.
struct ReportPose {
  std::array<double, 3> position_m{};
  std::array<double, 4> quaternion_wxyz{1, 0, 0, 0};
};

/// One frame's outcome. While nothing is found the pose, its covariance and `exposed_at` stay those of the last valid
/// one, and `valid` is false: a stale pose never looks fresh.
struct Report {
  std::uint32_t heartbeat = 0;              ///< +1 per processed frame, found or not
  std::uint32_t pose_sequence = 0;          ///< +1 per valid pose
  std::uint64_t frame_number = 0;           ///< of the frame this report is about
  MonoTime exposed_at{};                    ///< middle of the exposure of the frame that the POSE is from; 0 = never
  MonoTime published_at{};                  ///< when the frame loop published this report
  std::chrono::nanoseconds latency{};       ///< capture (mid-exposure) to publish of the last processed frame
  std::chrono::nanoseconds process_time{};  ///< detection and pose alone

  bool valid = false;       ///< pose is of this very frame and usable
  bool found = false;       ///< the frame shows a landmark
  bool ambiguous = false;   ///< ambiguity above the configured limit
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
  /// The same six 1-sigmas with the position along the world's axes: x y z [m], rotation about the world's x y z [rad].
  std::array<double, 6> sigma_world{};

  double ambiguity = 0;  ///< 0..1
  double rms_px = 0;
  std::uint16_t dots_used = 0;
  std::uint16_t occlusion_level = 0;
  double swing_psi_rad = 0, tilt_phi_rad = 0, pan_theta_rad = 0;
  double distance_m = 0, image_distance_m = 0, deviation_rad = 0;

  bool has_head = false;             ///< there is a pan/tilt head
  double pan_rad = 0, tilt_rad = 0;  ///< of the pan/tilt head; 0 without one
  bool servo_limit = false;          ///< the head stands at an end of its range and should go further
  bool servo_fault = false;          ///< the head could not be moved, or does not answer
  bool inhibited = false;            ///< the inhibit input keeps the head where it is
};
static_assert(std::is_trivially_copyable_v<Report>);

/// How the service is doing; published beside the reports, about once a second and at every change.
struct Health {
  MonoTime started_at{};
  double frame_rate_hz = 0;  ///< processed frames per second, over the last second
  std::uint32_t frames_processed = 0;
  std::uint32_t frames_dropped = 0;  ///< lost between the sensor and the frame loop
  std::uint32_t frames_failed = 0;   ///< arrived, but unreadable or of a wrong size
  std::uint32_t camera_restarts = 0;
  std::chrono::nanoseconds latency_median{}, latency_p99{}, latency_p999{}, latency_max{};
  std::chrono::nanoseconds pulse_error_p99{}, pulse_error_max{};  ///< of software-made servo pulses' widths, else 0
  double temperature_degC = 0;                                    ///< of the board, NaN where unknown
  bool realtime = false;                                          ///< the frame loop runs under SCHED_FIFO
  bool memory_locked = false;
};
static_assert(std::is_trivially_copyable_v<Health>);

}  // namespace ninedot
