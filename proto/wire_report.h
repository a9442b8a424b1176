#pragma once
/// What other machines see of one report: the numbers that registers and CSV rows are made from, in the units of the
/// outside, mm and degrees. Not a number = unknown: nothing of a pose is known before the first one.
#include <array>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "base/aim_state.h"
#include "base/mono_time.h"
#include "base/reason.h"
#include "proto/metrics.h"

namespace ninedot {

/// Stands for what is not known, whatever its unit: mm, degrees, ms, px.
inline constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();
/// WireReport::landmark_id before the first pose [1].
inline constexpr std::uint16_t kNoLandmarkYet = 0xFFFF;

/// A camera's pose in a named frame, or a robot body's.
struct WirePose {
  std::array<double, 3> position_mm{kUnknown, kUnknown, kUnknown};
  std::array<double, 4> quaternion_wxyz{kUnknown, kUnknown, kUnknown, kUnknown};  ///< rotates its vectors into it
};

/// What the pose registers carry. Register `pose_content`: never renumber.
enum class PoseContent : std::uint16_t { kCameraInWorld = 0, kCameraInLandmark = 1, kBodyInWorld = 2 };
/// How its rotation is told as three angles. Register `euler_convention`: never renumber.
enum class EulerConvention : std::uint16_t { kZyx = 0, kFanuc = 1, kKuka = 2 };

struct PoseOutput {
  PoseContent content = PoseContent::kCameraInWorld;
  EulerConvention euler = EulerConvention::kZyx;
};

struct WireReport {
  std::uint32_t frames_processed = 0;
  std::uint32_t pose_sequence = 0;
  std::uint64_t frame_number = 0;
  bool has_pose = false;         ///< there has been one
  MonoTime exposed_at{};         ///< of the pose
  double latency_ms = kUnknown;  ///< of the last processed frame
  double process_us = 0;

  bool valid = false, found = false, ambiguous = false, calibrated = false, tracking = false;
  bool ellipse_solver = false;  ///< else "full"
  Reason reason = Reason::kStarting;

  std::uint16_t landmark_id = kNoLandmarkYet;
  std::uint16_t quality = 0;  ///< 0..1000
  WirePose camera_in_landmark;
  std::array<double, 3> sigma_landmark_mm{kUnknown, kUnknown, kUnknown};  ///< of the position along the landmark's axes
  double sigma_rotation_deg = kUnknown;                                   ///< root of the sum of the three variances
  /// Of the position, all axes together: what of the sigmas above is the calibration's.
  double sigma_calibration_landmark_mm = kUnknown;

  // What the registers carry.
  PoseOutput output;
  WirePose pose;
  std::array<double, 3> sigma_mm{kUnknown, kUnknown, kUnknown};   ///< along the axes of the frame that it is in
  std::array<double, 3> sigma_deg{kUnknown, kUnknown, kUnknown};  ///< of the rotation about these axes
  /// Its rotation as angles: yaw, pitch, roll; W, P, R; or A, B, C.
  std::array<double, 3> angles_deg{kUnknown, kUnknown, kUnknown};
  std::array<double, 3> sigma_angles_deg{kUnknown, kUnknown, kUnknown};  ///< 1-sigma of each of them

  double sigma_calibration_mm = kUnknown;  ///< of the camera's position: what of `sigma_mm` is the calibration's

  double ambiguity = kUnknown;        ///< 0..1
  double rival_odds = 0;              ///< of the newest frame's second-likeliest reading, 0..1; 0: there is none
  WirePose rival_in_landmark, rival;  ///< its camera; what the registers carry
  std::uint16_t landmarks_seen = 0, landmarks_rejected = 0;  ///< in the newest frame
  std::uint16_t last_rejected_id = 65535;                    ///< 65535: none since the start
  std::uint16_t landmarks_disputed = 0;                      ///< that contradict each other, undecided
  std::array<std::uint16_t, 2> disputed_ids{65535, 65535};   ///< two of them; 65535: none
  double rms_px = kUnknown;
  std::uint16_t dots_used = 0, occlusion_level = 0;
  double swing_psi_deg = kUnknown, tilt_phi_deg = kUnknown, pan_theta_deg = kUnknown;
  double distance_mm = kUnknown;

  bool has_head = false, servo_limit = false, servo_fault = false, inhibited = false;
  double pan_deg = 0, tilt_deg = 0;  ///< 0 without a head
  AimState head_state = AimState::kNone;
};
static_assert(std::is_trivially_copyable_v<WireReport>);

/// One moment of the service as others see it.
struct WireState {
  WireReport report;
  MetricValues metrics;  ///< what the report and the frame loop say; the Modbus servers add their own
};

/// Where Modbus servers get what they show.
class WireSource {
 public:
  virtual ~WireSource() = default;
  /// The newest. \param now  the moment of the reply. Memory: none. Threads: any ordinary one; never sleeps.
  virtual WireState read(MonoTime now) const noexcept = 0;
};

}  // namespace ninedot
