#pragma once
/// What another machine reads and writes over Modbus: one normative table. The constants in `reg`, the codec,
/// docs/registers.md and the tests follow from it.
///
/// Addresses are 0-based, as they stand in the request on the wire. Function codes 03 and 04 show the same contents.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>

#include "base/contract.h"
#include "proto/metrics.h"
#include "proto/register_entry.h"

namespace ninedot {

/// Bumped when an address changes its meaning; new registers in gaps leave it alone.
inline constexpr std::uint16_t kRegisterMapVersion = 1;
inline constexpr std::uint16_t kRegisterMapMagic = 0x9D09;

/// A board's serial number as registers carry it [characters]: as long as a Raspberry Pi's.
inline constexpr std::size_t kBoardSerialLength = 16;

/// Every address has an entry. From here on: exception 02. One request of 125 registers (the protocol's limit) reads
/// all but the angles, who the device is, and its servos.
inline constexpr std::size_t kRegisterCount = 168;

// The map without the metrics, which have their own table.
// clang-format off
inline constexpr auto kOwnRegisters = [] {
  using enum RegisterType;
  using enum RegisterAccess;
  using namespace register_ranges;
  return std::to_array<RegisterEntry>({
  {  0, "magic",               kU16,       1,      "",     0,        kU16Max, kRead, "0x9D09 (40201): anything else is an address that is off by one, or another device"},
  {  1, "map_version",         kU16,       1,      "",     0,        kU16Max, kRead, "version of this map"},
  {  2, "heartbeat",           kCounter16, 1,      "",     0,        kU16Max, kRead, "+1 per processed frame, landmark or not: the device lives"},
  {  3, "pose_sequence",       kCounter16, 1,      "",     0,        kU16Max, kRead, "+1 per valid pose: the data is new"},
  {  4, "status",              kBits16,    1,      "",     0,        kU16Max, kRead, "status bits, see below"},
  {  5, "reason",              kU16,       1,      "",     0,        kU16Max, kRead, "why the pose is not valid, see below; 0 while it is"},
  {  6, "landmark_id",         kU16,       1,      "",     0,        kU16Max, kRead, "the landmark that the pose rests on; 65535 before the first pose"},
  {  7, "quality",             kU16,       1,      "",     0,        1000,    kRead, "0 unusable .. 1000 best; 0 while the pose is not valid"},
  {  8, "age",                 kU16,       0.1,    "ms",   0,        kU16Max, kRead, "age of the pose at the moment of the reply, from the middle of its exposure; saturates, also before the first pose"},
  {  9, "latency",             kU16,       0.1,    "ms",   0,        kU16Max, kRead, "middle of the exposure to published report, of the last processed frame; 65535 before the first"},
  { 10, "x_16",                kI16,       0.5,    "mm",   -kI16Max, kI16Max, kRead, "camera's optical centre in the world (register 125 says if it is another pose), x", true},
  { 11, "y_16",                kI16,       0.5,    "mm",   -kI16Max, kI16Max, kRead, "the same, y", true},
  { 12, "z_16",                kI16,       0.5,    "mm",   -kI16Max, kI16Max, kRead, "the same, z (up)", true},
  { 13, "rotation_x_16",       kI16,       1,      "mrad", -kI16Max, kI16Max, kRead, "rotation vector camera to world (axis times angle, angle 0..pi), x"},
  { 14, "rotation_y_16",       kI16,       1,      "mrad", -kI16Max, kI16Max, kRead, "the same, y"},
  { 15, "rotation_z_16",       kI16,       1,      "mrad", -kI16Max, kI16Max, kRead, "the same, z"},
  { 16, "x_32",                kI32,       0.001,  "mm",   -kI32Max, kI32Max, kRead, "camera's optical centre in the world, x"},
  { 18, "y_32",                kI32,       0.001,  "mm",   -kI32Max, kI32Max, kRead, "the same, y"},
  { 20, "z_32",                kI32,       0.001,  "mm",   -kI32Max, kI32Max, kRead, "the same, z (up)"},
  { 22, "rotation_x_32",       kI32,       0.001,  "deg",  -kI32Max, kI32Max, kRead, "rotation vector camera to world, x"},
  { 24, "rotation_y_32",       kI32,       0.001,  "deg",  -kI32Max, kI32Max, kRead, "the same, y"},
  { 26, "rotation_z_32",       kI32,       0.001,  "deg",  -kI32Max, kI32Max, kRead, "the same, z"},
  { 28, "sigma_x",             kU16,       0.01,   "mm",   1,        kU16Max, kRead, "1-sigma of x; never 0; 65535 also before the first pose"},
  { 29, "sigma_y",             kU16,       0.01,   "mm",   1,        kU16Max, kRead, "1-sigma of y"},
  { 30, "sigma_z",             kU16,       0.01,   "mm",   1,        kU16Max, kRead, "1-sigma of z"},
  { 31, "sigma_rotation_x",    kU16,       0.001,  "deg",  1,        kU16Max, kRead, "1-sigma of the rotation about the world's x"},
  { 32, "sigma_rotation_y",    kU16,       0.001,  "deg",  1,        kU16Max, kRead, "the same about y"},
  { 33, "sigma_rotation_z",    kU16,       0.001,  "deg",  1,        kU16Max, kRead, "the same about z"},
  { 34, "ambiguity",           kU16,       0.001,  "",     0,        1000,    kRead, "odds that another reading (mirror image, numbering) is right; of the newest frame while status bit ambiguous is set"},
  { 35, "residual",            kU16,       0.001,  "px",   0,        kU16Max, kRead, "root mean square residual of the fit"},
  { 36, "dots_used",           kU16,       1,      "",     0,        kU16Max, kRead, "dots that the pose rests on, 0..9"},
  { 37, "pan",                 kI16,       0.01,   "deg",  -kI16Max, kI16Max, kRead, "of the pan/tilt head, positive to the left; 0 without one"},
  { 38, "tilt",                kI16,       0.01,   "deg",  -kI16Max, kI16Max, kRead, "of the pan/tilt head, positive upwards; 0 without one"},
  { 39, "pose_sequence_copy",  kCounter16, 1,      "",     0,        kU16Max, kRead, "equals register 3, or the controller has mixed two replies"},
  { 40, "x_float",             kF32,       1,      "mm",   0,        0,       kRead, "camera's optical centre in the world, x"},
  { 42, "y_float",             kF32,       1,      "mm",   0,        0,       kRead, "the same, y"},
  { 44, "z_float",             kF32,       1,      "mm",   0,        0,       kRead, "the same, z (up)"},
  { 46, "qw_float",            kF32,       1,      "",     0,        0,       kRead, "quaternion camera to world, w >= 0"},
  { 48, "qx_float",            kF32,       1,      "",     0,        0,       kRead, "the same, x"},
  { 50, "qy_float",            kF32,       1,      "",     0,        0,       kRead, "the same, y"},
  { 52, "qz_float",            kF32,       1,      "",     0,        0,       kRead, "the same, z"},
  { 54, "rival_x_32",          kI32,       0.001,  "mm",   -kI32Max, kI32Max, kRead, "where the camera is by the likeliest other reading of the newest frame, x in the world; unknown while there is none"},
  { 56, "rival_y_32",          kI32,       0.001,  "mm",   -kI32Max, kI32Max, kRead, "the same, y"},
  { 58, "rival_z_32",          kI32,       0.001,  "mm",   -kI32Max, kI32Max, kRead, "the same, z (up)"},
  { 78, "health_flags",        kBits16,    1,      "",     0,        kU16Max, kRead, "health flags, see below"},
  { 80, "probe_int32",         kI32,       1,      "",     -kI32Max, kI32Max, kRead, "always -1 (0xFFFF 0xFFFF): signed numbers are read as signed"},
  { 82, "probe_word_order",    kU32,       1,      "",     0,        kU32Max, kRead, "always 0x12345678: the word order of 32-bit integers"},
  { 84, "probe_float",         kF32,       1,      "",     0,        0,       kRead, "always 123456.0: the word order of float32"},
  {100, "command",             kU16,       1,      "",     0,        kU16Max, kReadWrite, "command code, see below; carried out when register 101 changes"},
  {101, "command_sequence",    kU16,       1,      "",     0,        kU16Max, kReadWrite, "write a number other than the last one to carry out register 100"},
  {102, "command_acknowledge", kU16,       1,      "",     0,        kU16Max, kRead, "command_sequence of the last command that has ended; one whose place a newer one took does not end"},
  {103, "command_result",      kU16,       1,      "",     0,        kU16Max, kRead, "of command_sequence: 0 none yet, 1 running, 2 done, 3 failed, see below"},
  {104, "hold",                kU16,       1,      "",     0,        1,       kReadWrite, "1 freezes registers 2-59 and 118-147 for this client (age and staleness go on); 0 releases; releases itself"},
  {105, "pan_set_point",       kI16,       0.01,   "deg",  -18000,   18000,   kReadWrite, "for command 2, positive to the left"},
  {106, "tilt_set_point",      kI16,       0.01,   "deg",  -9000,    9000,    kReadWrite, "for command 2, positive upwards"},
  {107, "client_watchdog",     kU16,       1,      "ms",   0,        kU16Max, kReadWrite, "0 off; else this client must send a request within this time, or the head goes back to following"},
  {118, "rival_rotation_x_16", kI16,       1,      "mrad", -kI16Max, kI16Max, kRead, "of the reading of registers 54-59: rotation vector camera to world, x"},
  {119, "rival_rotation_y_16", kI16,       1,      "mrad", -kI16Max, kI16Max, kRead, "the same, y"},
  {120, "rival_rotation_z_16", kI16,       1,      "mrad", -kI16Max, kI16Max, kRead, "the same, z"},
  {121, "rival_odds",          kU16,       0.001,  "",     0,        1000,    kRead, "odds that it is the right one; 0 while there is none"},
  {122, "landmarks_seen",      kU16,       1,      "",     0,        kU16Max, kRead, "landmarks of the map that the newest frame shows"},
  {123, "landmarks_rejected",  kU16,       1,      "",     0,        kU16Max, kRead, "of these, those that do not hang where the map says: the pose is made of the others"},
  {124, "last_rejected_id",    kU16,       1,      "",     0,        kU16Max, kRead, "the landmark that was rejected last, in whichever frame; 65535: none since the start"},
  {125, "pose_content",        kU16,       1,      "",     0,        kU16Max, kRead, "what registers 10-33, 40-59, 118-120 and 127-144 carry, see below"},
  {126, "euler_convention",    kU16,       1,      "",     0,        kU16Max, kRead, "what angles 1 to 3 are, see below"},
  {127, "angle_1_32",          kI32,       0.001,  "deg",  -kI32Max, kI32Max, kRead, "the rotation of registers 22-27 as three angles: the first"},
  {129, "angle_2_32",          kI32,       0.001,  "deg",  -kI32Max, kI32Max, kRead, "the same, the second"},
  {131, "angle_3_32",          kI32,       0.001,  "deg",  -kI32Max, kI32Max, kRead, "the same, the third"},
  {133, "sigma_angle_1",       kU16,       0.001,  "deg",  1,        kU16Max, kRead, "1-sigma of the first angle; 65535 also where pitch is at +-90 deg, and before the first pose"},
  {134, "sigma_angle_2",       kU16,       0.001,  "deg",  1,        kU16Max, kRead, "the same of the second"},
  {135, "sigma_angle_3",       kU16,       0.001,  "deg",  1,        kU16Max, kRead, "the same of the third"},
  {136, "angle_1_16",          kI16,       0.01,   "deg",  -kI16Max, kI16Max, kRead, "the first angle"},
  {137, "angle_2_16",          kI16,       0.01,   "deg",  -kI16Max, kI16Max, kRead, "the second angle"},
  {138, "angle_3_16",          kI16,       0.01,   "deg",  -kI16Max, kI16Max, kRead, "the third angle"},
  {139, "angle_1_float",       kF32,       1,      "deg",  0,        0,       kRead, "the first angle"},
  {141, "angle_2_float",       kF32,       1,      "deg",  0,        0,       kRead, "the second angle"},
  {143, "angle_3_float",       kF32,       1,      "deg",  0,        0,       kRead, "the third angle"},
  {145, "pose_sequence_end",   kCounter16, 1,      "",     0,        kU16Max, kRead, "equals register 3, or the angles are of another pose"},
  {146, "head_state",          kU16,       1,      "",     0,        kU16Max, kRead, "what the pan/tilt head is doing, see below; 0 without one"},
  {147, "sigma_calibration",   kU16,       0.01,   "mm",   0,        kU16Max, kRead, "1-sigma of the camera's position, all axes together, by its calibration alone; part of the sigmas above; 65535 where the calibration does not say how good it is"},
  {148, "software_major",      kU16,       1,      "",     0,        kU16Max, kRead, "version of the software, MAJOR.minor.patch"},
  {149, "software_minor",      kU16,       1,      "",     0,        kU16Max, kRead, "the same, major.MINOR.patch"},
  {150, "software_patch",      kU16,       1,      "",     0,        kU16Max, kRead, "the same, major.minor.PATCH"},
  {151, "board_serial_1",      kU16,       1,      "",     0,        kU16Max, kRead, "serial number of the board, 16 characters of ASCII in 151-158: the first in the high byte, the second in the low one; 0 behind the last; all 0: the board tells none"},
  {152, "board_serial_2",      kU16,       1,      "",     0,        kU16Max, kRead, "the same, characters 3 and 4"},
  {153, "board_serial_3",      kU16,       1,      "",     0,        kU16Max, kRead, "the same, characters 5 and 6"},
  {154, "board_serial_4",      kU16,       1,      "",     0,        kU16Max, kRead, "the same, characters 7 and 8"},
  {155, "board_serial_5",      kU16,       1,      "",     0,        kU16Max, kRead, "the same, characters 9 and 10"},
  {156, "board_serial_6",      kU16,       1,      "",     0,        kU16Max, kRead, "the same, characters 11 and 12"},
  {157, "board_serial_7",      kU16,       1,      "",     0,        kU16Max, kRead, "the same, characters 13 and 14"},
  {158, "board_serial_8",      kU16,       1,      "",     0,        kU16Max, kRead, "the same, characters 15 and 16"},
  {164, "landmarks_disputed",  kU16,       1,      "",     0,        kU16Max, kRead, "landmarks of the map that contradict each other, with nothing that says which of them hangs elsewhere: none of them places the camera alone"},
  {165, "disputed_id_1",       kU16,       1,      "",     0,        kU16Max, kRead, "one of these; 65535: none"},
  {166, "disputed_id_2",       kU16,       1,      "",     0,        kU16Max, kRead, "another one; 65535: none"},
  {167, "give_way",            kU16,       1,      "",     0,        1,       kReadWrite, "1: what this client writes to 100, 101, 105 and 106 is refused while another one has written there since this one last read; 0: it is carried out"},
  });
}();
// clang-format on

/// The whole map, by address: the registers above and those of kMetrics.
inline constexpr auto kRegisterMap = [] {
  constexpr auto kFlags = static_cast<std::size_t>(
      std::count_if(kMetrics.begin(), kMetrics.end(), [](const Metric& m) { return m.kind == MetricKind::kFlag; }));
  std::array<RegisterEntry, kOwnRegisters.size() + kMetricCount - kFlags> map{};
  auto* const end = std::copy(kOwnRegisters.begin(), kOwnRegisters.end(), map.begin());
  auto* to = end;
  for (const Metric& metric : kMetrics)
    if (metric.kind != MetricKind::kFlag) *to++ = register_of(metric);
  std::sort(map.begin(), map.end(), [](const auto& a, const auto& b) { return a.address < b.address; });
  return map;
}();

/// Place in the table of the entry whose first word is at `address`; the table's size if there is none.
constexpr std::size_t register_index(std::uint16_t address) noexcept {
  std::size_t i = 0;
  while (i < kRegisterMap.size() && kRegisterMap[i].address != address) ++i;
  return i;
}

/// The entry whose first word is at `address`, or null.
constexpr const RegisterEntry* find_register(std::uint16_t address) noexcept {
  const std::size_t i = register_index(address);
  return i < kRegisterMap.size() ? &kRegisterMap[i] : nullptr;
}

/// Address by name, at compile time: a wrong name does not compile.
consteval std::uint16_t register_address(std::string_view name) {
  for (const RegisterEntry& entry : kRegisterMap)
    if (entry.name == name) return entry.address;
  throw "no register of this name";
}

/// The addresses that code uses by name.
namespace reg {
#define NINEDOT_REGISTER(constant, name) inline constexpr std::uint16_t constant = register_address(name)
NINEDOT_REGISTER(kMagic, "magic");
NINEDOT_REGISTER(kMapVersion, "map_version");
NINEDOT_REGISTER(kHeartbeat, "heartbeat");
NINEDOT_REGISTER(kPoseSequence, "pose_sequence");
NINEDOT_REGISTER(kStatus, "status");
NINEDOT_REGISTER(kReason, "reason");
NINEDOT_REGISTER(kLandmarkId, "landmark_id");
NINEDOT_REGISTER(kQuality, "quality");
NINEDOT_REGISTER(kAge, "age");
NINEDOT_REGISTER(kLatency, "latency");
NINEDOT_REGISTER(kX16, "x_16");
NINEDOT_REGISTER(kRotationX16, "rotation_x_16");
NINEDOT_REGISTER(kX32, "x_32");
NINEDOT_REGISTER(kRotationX32, "rotation_x_32");
NINEDOT_REGISTER(kSigmaX, "sigma_x");
NINEDOT_REGISTER(kSigmaRotationX, "sigma_rotation_x");
NINEDOT_REGISTER(kAmbiguity, "ambiguity");
NINEDOT_REGISTER(kResidual, "residual");
NINEDOT_REGISTER(kDotsUsed, "dots_used");
NINEDOT_REGISTER(kPan, "pan");
NINEDOT_REGISTER(kTilt, "tilt");
NINEDOT_REGISTER(kPoseSequenceCopy, "pose_sequence_copy");
NINEDOT_REGISTER(kXFloat, "x_float");
NINEDOT_REGISTER(kQwFloat, "qw_float");
NINEDOT_REGISTER(kFrameRate, "frame_rate");
NINEDOT_REGISTER(kFramesProcessed, "frames_processed");
NINEDOT_REGISTER(kFramesDropped, "frames_dropped");
NINEDOT_REGISTER(kFramesFailed, "frames_failed");
NINEDOT_REGISTER(kCameraRestarts, "camera_restarts");
NINEDOT_REGISTER(kLatencyMedian, "latency_median");
NINEDOT_REGISTER(kLatencyP99, "latency_p99");
NINEDOT_REGISTER(kLatencyP999, "latency_p999");
NINEDOT_REGISTER(kLatencyMax, "latency_max");
NINEDOT_REGISTER(kTemperature, "temperature");
NINEDOT_REGISTER(kUptime, "uptime");
NINEDOT_REGISTER(kBusErrors, "bus_errors");
NINEDOT_REGISTER(kConnectedClients, "connected_clients");
NINEDOT_REGISTER(kHealthFlags, "health_flags");
NINEDOT_REGISTER(kExceptions, "exceptions");
NINEDOT_REGISTER(kProbeInt32, "probe_int32");
NINEDOT_REGISTER(kProbeWordOrder, "probe_word_order");
NINEDOT_REGISTER(kRivalX32, "rival_x_32");
NINEDOT_REGISTER(kRivalRotationX16, "rival_rotation_x_16");
NINEDOT_REGISTER(kRivalOdds, "rival_odds");
NINEDOT_REGISTER(kLandmarksSeen, "landmarks_seen");
NINEDOT_REGISTER(kLandmarksRejected, "landmarks_rejected");
NINEDOT_REGISTER(kLastRejectedId, "last_rejected_id");
NINEDOT_REGISTER(kLandmarksDisputed, "landmarks_disputed");
NINEDOT_REGISTER(kDisputedId, "disputed_id_1");
NINEDOT_REGISTER(kPoseContent, "pose_content");
NINEDOT_REGISTER(kEulerConvention, "euler_convention");
NINEDOT_REGISTER(kAngle32, "angle_1_32");
NINEDOT_REGISTER(kSigmaAngle, "sigma_angle_1");
NINEDOT_REGISTER(kAngle16, "angle_1_16");
NINEDOT_REGISTER(kAngleFloat, "angle_1_float");
NINEDOT_REGISTER(kPoseSequenceEnd, "pose_sequence_end");
NINEDOT_REGISTER(kHeadState, "head_state");
NINEDOT_REGISTER(kSigmaCalibration, "sigma_calibration");
NINEDOT_REGISTER(kSoftwareMajor, "software_major");
NINEDOT_REGISTER(kSoftwareMinor, "software_minor");
NINEDOT_REGISTER(kSoftwarePatch, "software_patch");
NINEDOT_REGISTER(kBoardSerial, "board_serial_1");
NINEDOT_REGISTER(kProbeFloat, "probe_float");
NINEDOT_REGISTER(kPulseErrorP99, "pulse_error_p99");
NINEDOT_REGISTER(kPulseErrorMax, "pulse_error_max");
NINEDOT_REGISTER(kCommand, "command");
NINEDOT_REGISTER(kCommandSequence, "command_sequence");
NINEDOT_REGISTER(kCommandAcknowledge, "command_acknowledge");
NINEDOT_REGISTER(kCommandResult, "command_result");
NINEDOT_REGISTER(kHold, "hold");
NINEDOT_REGISTER(kPanSetPoint, "pan_set_point");
NINEDOT_REGISTER(kTiltSetPoint, "tilt_set_point");
NINEDOT_REGISTER(kClientWatchdog, "client_watchdog");
NINEDOT_REGISTER(kGiveWay, "give_way");
#undef NINEDOT_REGISTER
}  // namespace reg

/// One bit of a kBits16 register.
struct RegisterBit {
  std::uint16_t mask;
  std::string_view name;
  std::string_view meaning;
};

/// Bits of register `status`. Normative.
namespace status_bit {
/// Masks [1].
inline constexpr std::uint16_t kValid = 1U << 0, kFound = 1U << 1, kAmbiguous = 1U << 2, kStale = 1U << 3,
                               kCalibrated = 1U << 4, kServoLimit = 1U << 5, kThrottled = 1U << 6, kTracking = 1U << 7,
                               kEllipseSolver = 1U << 8, kHeld = 1U << 9, kWritesEnabled = 1U << 10,
                               kInhibited = 1U << 11, kServoFault = 1U << 12, kHasHead = 1U << 13;
}  // namespace status_bit
extern const std::span<const RegisterBit> kStatusBits;

/// Bits of register `health_flags`. Normative; the flags of kMetrics.
namespace health_bit {
/// Masks [1].
inline constexpr std::uint16_t kRealtime = metric_of(MetricId::kRealtime).address,
                               kMemoryLocked = metric_of(MetricId::kMemoryLocked).address,
                               kSerialOpen = metric_of(MetricId::kSerialOpen).address;
}  // namespace health_bit
extern const std::span<const RegisterBit> kHealthBits;

/// A number and what it stands for: codes in registers.
struct RegisterCode {
  std::uint16_t code;
  std::string_view meaning;
};
extern const std::span<const RegisterCode>
    kReasonCodes;  ///< register `reason`; the numbers are enum Reason (base/reason.h)

extern const std::span<const RegisterCode> kPoseContentCodes;  ///< register `pose_content`, enum PoseContent
extern const std::span<const RegisterCode> kHeadStateCodes;    ///< register `head_state`, enum AimState
extern const std::span<const RegisterCode> kEulerCodes;        ///< register `euler_convention`, enum EulerConvention

/// Register `command`. Never renumber.
enum class Command : std::uint16_t {
  kNone = 0,    ///< nothing
  kFollow = 1,  ///< the head follows the landmark
  kPoint = 2,   ///< the head moves to the set-points and stays there
  kPark = 3,    ///< the head moves to its parking place and stays there
};
inline constexpr std::uint16_t kLastCommand = 3;
extern const std::span<const RegisterCode> kCommandCodes;

/// Register `command_result`: of the command in `command_sequence`.
enum class CommandResult : std::uint16_t { kNone = 0, kRunning = 1, kDone = 2, kFailed = 3 };

}  // namespace ninedot
