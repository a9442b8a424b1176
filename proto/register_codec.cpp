/// encode_registers names every register once and says which number goes in; the table says how it is written.
#include "proto/register_codec.h"
#include "base/units.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

namespace ninedot {
namespace {

constexpr double kNaN = kUnknown;

bool is_signed(RegisterType type) { return type == RegisterType::kI16 || type == RegisterType::kI32; }

double step_of(const RegisterEntry& entry, const RegisterCodecOptions& options) {
  return entry.scale_is_configured ? options.position_step_mm : entry.scale;
}

void put_words(std::uint32_t bits, bool high_first, std::span<std::uint16_t> words) noexcept {
  if (words.size() == 1) {
    words[0] = static_cast<std::uint16_t>(bits & 0xFFFFU);
    return;
  }
  words[high_first ? 0 : 1] = static_cast<std::uint16_t>(bits >> 16U);
  words[high_first ? 1 : 0] = static_cast<std::uint16_t>(bits & 0xFFFFU);
}

std::uint32_t bits_of(std::span<const std::uint16_t> words, bool high_first) noexcept {
  if (words.size() == 1) return words[0];
  const std::uint32_t high = words[high_first ? 0 : 1], low = words[high_first ? 1 : 0];
  return high << 16U | low;
}

std::uint32_t float_bits(double value) noexcept {
  constexpr double kMax = std::numeric_limits<float>::max();
  // A fixed quiet NaN: the sign and payload of the processor's own differ between boards.
  if (std::isnan(value)) return 0x7FC00000U;
  return std::bit_cast<std::uint32_t>(static_cast<float>(std::clamp(value, -kMax, kMax)));
}

/// Steps of an integer register, saturated; NaN becomes the value that stands for "unknown".
std::int64_t steps_of(const RegisterEntry& entry, double value, double step) noexcept {
  if (std::isnan(value)) return is_signed(entry.type) ? -entry.highest - 1 : entry.highest;
  // Both ends fit a double exactly; comparing before the cast keeps infinities out of it.
  const double steps = std::round(value / step);
  if (steps <= static_cast<double>(entry.lowest)) return entry.lowest;
  if (steps >= static_cast<double>(entry.highest)) return entry.highest;
  return static_cast<std::int64_t>(steps);
}

/// Writes one reply's registers; the entry is looked up at compile time.
class Writer {
 public:
  Writer(RegisterBlock& block, const RegisterCodecOptions& options) : block_(block), options_(options) {}

  template <std::uint16_t Address, std::uint16_t Offset = 0>
  void put(double value) noexcept {
    constexpr std::size_t kIndex = register_index(Address + Offset);
    static_assert(kIndex < kRegisterMap.size(), "no register starts at this address");
    const RegisterEntry& entry = kRegisterMap[kIndex];
    encode_value(entry, value, options_, std::span(block_).subspan(entry.address, entry.words()));
  }
  template <std::uint16_t Address>
  void count(std::uint32_t value) noexcept {
    constexpr std::size_t kIndex = register_index(Address);
    static_assert(kIndex < kRegisterMap.size(), "no register starts at this address");
    constexpr RegisterType kType = kRegisterMap[kIndex].type;
    static_assert(kType == RegisterType::kCounter16 || kType == RegisterType::kCounter32);
    put_words(value, true, std::span(block_).subspan(Address, kRegisterMap[kIndex].words()));
  }
  /// Three entries in a row: x, y, z, or three angles.
  template <std::uint16_t Address>
  void put_xyz(const std::array<double, 3>& xyz) noexcept {
    constexpr std::uint16_t kStride = kRegisterMap[register_index(Address)].words();
    put<Address>(xyz[0]);
    put<Address, kStride>(xyz[1]);
    put<Address, 2 * kStride>(xyz[2]);
  }

 private:
  RegisterBlock& block_;
  const RegisterCodecOptions& options_;
};

/// Rotation vector [rad], angle in [0, pi], of a unit quaternion with w >= 0: 2 atan2(|v|, w) v / |v|.
std::array<double, 3> rotation_vector_rad(const std::array<double, 4>& wxyz) noexcept {
  const double norm = std::sqrt(wxyz[1] * wxyz[1] + wxyz[2] * wxyz[2] + wxyz[3] * wxyz[3]);
  // Below, the quotient's limit 2 / w is exact to a double's precision.
  const double factor = norm < 1e-9 ? 2.0 / wxyz[0] : 2.0 * std::atan2(norm, wxyz[0]) / norm;
  return {factor * wxyz[1], factor * wxyz[2], factor * wxyz[3]};
}

std::array<double, 3> scaled(const std::array<double, 3>& v, double factor) noexcept {
  return {factor * v[0], factor * v[1], factor * v[2]};
}

double ms_of(std::chrono::nanoseconds duration) noexcept { return static_cast<double>(duration.count()) * 1e-6; }

/// What a client reads as the reason: a valid pose may have grown old since, for want of newer ones or in its own hold.
Reason reason_now(const WireReport& report, bool stale, bool held) noexcept {
  if (!report.valid || !stale) return report.reason;
  return held ? Reason::kHeld : Reason::kStale;
}

void put_state(Writer& out, const WireReport& report, const ServerState& server,
               const RegisterCodecOptions& options) noexcept {
  const bool has_pose = report.has_pose;
  const std::chrono::nanoseconds age = server.now - report.exposed_at;
  const bool stale = !has_pose || age > options.stale_after;
  const bool valid = report.valid && !stale;

  std::uint16_t status = 0;
  const auto set = [&status](bool condition, std::uint16_t bit) {
    if (condition) status = static_cast<std::uint16_t>(status | bit);
  };
  set(valid, status_bit::kValid);
  set(report.found, status_bit::kFound);
  set(report.ambiguous, status_bit::kAmbiguous);
  set(stale, status_bit::kStale);
  set(report.calibrated, status_bit::kCalibrated);
  set(report.tracking, status_bit::kTracking);
  set(report.ellipse_solver, status_bit::kEllipseSolver);
  set(report.servo_limit, status_bit::kServoLimit);
  set(report.inhibited, status_bit::kInhibited);
  set(report.servo_fault, status_bit::kServoFault);
  set(report.has_head, status_bit::kHasHead);
  set(server.commands.hold, status_bit::kHeld);
  set(server.writes_enabled, status_bit::kWritesEnabled);

  out.put<reg::kMagic>(kRegisterMapMagic);
  out.put<reg::kMapVersion>(kRegisterMapVersion);
  out.count<reg::kHeartbeat>(report.frames_processed);
  out.count<reg::kPoseSequence>(report.pose_sequence);
  out.put<reg::kStatus>(status);
  out.put<reg::kReason>(static_cast<double>(reason_now(report, stale, server.commands.hold)));
  out.put<reg::kLandmarkId>(report.landmark_id);
  out.put<reg::kQuality>(valid ? report.quality : 0);
  out.put<reg::kAge>(has_pose ? ms_of(age) : std::numeric_limits<double>::infinity());
  out.put<reg::kLatency>(report.latency_ms);
}

void put_pose(Writer& out, const WireReport& report) noexcept {
  const WirePose& pose = report.pose;
  const std::array<double, 3> rotation_rad = rotation_vector_rad(pose.quaternion_wxyz);
  out.put_xyz<reg::kX16>(pose.position_mm);
  out.put_xyz<reg::kRotationX16>(scaled(rotation_rad, 1e3));
  out.put_xyz<reg::kX32>(pose.position_mm);
  out.put_xyz<reg::kRotationX32>(scaled(rotation_rad, kDegPerRad));

  out.put_xyz<reg::kSigmaX>(report.sigma_mm);
  out.put_xyz<reg::kSigmaRotationX>(report.sigma_deg);
  out.put<reg::kAmbiguity>(report.ambiguity);
  out.put<reg::kResidual>(report.rms_px);
  out.put<reg::kDotsUsed>(report.dots_used);
  out.put<reg::kPan>(report.pan_deg);
  out.put<reg::kTilt>(report.tilt_deg);
  out.count<reg::kPoseSequenceCopy>(report.pose_sequence);

  out.put_xyz<reg::kXFloat>(pose.position_mm);
  out.put<reg::kQwFloat>(pose.quaternion_wxyz[0]);
  out.put<reg::kQwFloat, 2>(pose.quaternion_wxyz[1]);
  out.put<reg::kQwFloat, 4>(pose.quaternion_wxyz[2]);
  out.put<reg::kQwFloat, 6>(pose.quaternion_wxyz[3]);
}

void put_angles(Writer& out, const WireReport& report) noexcept {
  out.put<reg::kPoseContent>(static_cast<double>(report.output.content));
  out.put<reg::kEulerConvention>(static_cast<double>(report.output.euler));
  out.put_xyz<reg::kAngle32>(report.angles_deg);
  out.put_xyz<reg::kSigmaAngle>(report.sigma_angles_deg);
  out.put_xyz<reg::kAngle16>(report.angles_deg);
  out.put_xyz<reg::kAngleFloat>(report.angles_deg);
  out.count<reg::kPoseSequenceEnd>(report.pose_sequence);
  out.put<reg::kSigmaCalibration>(report.sigma_calibration_mm);
}

void put_others(Writer& out, const WireReport& report) noexcept {
  out.put_xyz<reg::kRivalX32>(report.rival.position_mm);
  out.put_xyz<reg::kRivalRotationX16>(scaled(rotation_vector_rad(report.rival.quaternion_wxyz), 1e3));
  out.put<reg::kRivalOdds>(report.rival_odds);
  out.put<reg::kLandmarksSeen>(report.landmarks_seen);
  out.put<reg::kLandmarksRejected>(report.landmarks_rejected);
  out.put<reg::kLastRejectedId>(report.last_rejected_id);
  out.put<reg::kLandmarksDisputed>(report.landmarks_disputed);
  out.put<reg::kDisputedId>(report.disputed_ids[0]);
  out.put<reg::kDisputedId, 1>(report.disputed_ids[1]);
  out.put<reg::kHeadState>(static_cast<double>(report.head_state));
}

void put_metrics(RegisterBlock& block, const MetricValues& metrics, const RegisterCodecOptions& options) noexcept {
  for (const Metric& metric : kMetrics) {
    const double value = metrics[metric.id];
    if (metric.kind == MetricKind::kFlag) {
      if (value != 0) block[reg::kHealthFlags] = static_cast<std::uint16_t>(block[reg::kHealthFlags] | metric.address);
      continue;
    }
    const RegisterEntry entry = register_of(metric);
    const std::span<std::uint16_t> words = std::span(block).subspan(entry.address, entry.words());
    if (metric.type == RegisterType::kCounter32)
      put_words(static_cast<std::uint32_t>(static_cast<std::uint64_t>(value)), true, words);
    else
      encode_value(entry, value, options, words);
  }
}

void put_commands(Writer& out, const CommandRegisters& commands) noexcept {
  out.put<reg::kCommand>(commands.command);
  out.put<reg::kCommandSequence>(commands.sequence);
  out.put<reg::kCommandAcknowledge>(commands.acknowledge);
  out.put<reg::kCommandResult>(static_cast<double>(commands.result));
  out.put<reg::kHold>(commands.hold ? 1 : 0);
  out.put<reg::kPanSetPoint>(commands.pan_set_point_deg);
  out.put<reg::kTiltSetPoint>(commands.tilt_set_point_deg);
  out.put<reg::kClientWatchdog>(static_cast<double>(commands.client_watchdog.count()));
  out.put<reg::kGiveWay>(commands.give_way ? 1 : 0);
}

void put_identity(Writer& out, RegisterBlock& block, const DeviceIdentity& identity) noexcept {
  out.put<reg::kSoftwareMajor>(identity.version[0]);
  out.put<reg::kSoftwareMinor>(identity.version[1]);
  out.put<reg::kSoftwarePatch>(identity.version[2]);
  for (std::size_t i = 0; i < identity.board_serial.size(); i += 2) {
    const auto byte = [&](std::size_t at) { return static_cast<unsigned char>(identity.board_serial[at]); };
    block[reg::kBoardSerial + i / 2] = static_cast<std::uint16_t>(byte(i) << 8U | byte(i + 1));
  }
}

}  // namespace

void encode_value(const RegisterEntry& entry, double value, const RegisterCodecOptions& options,
                  std::span<std::uint16_t> words) noexcept {
  EXPECTS(words.size() == entry.words() && options.position_step_mm > 0);
  if (entry.type == RegisterType::kF32) {
    put_words(float_bits(value), options.float_word_order == WordOrder::kHighFirst, words);
    return;
  }
  // The low 32 bits of the two's complement are the register's bits, for signed and unsigned alike.
  put_words(static_cast<std::uint32_t>(steps_of(entry, value, step_of(entry, options)) & 0xFFFFFFFF), true, words);
}

double decode_value(const RegisterEntry& entry, std::span<const std::uint16_t> words,
                    const RegisterCodecOptions& options) noexcept {
  EXPECTS(words.size() == entry.words());
  if (entry.type == RegisterType::kF32) {
    const bool high_first = options.float_word_order == WordOrder::kHighFirst;
    return static_cast<double>(std::bit_cast<float>(bits_of(words, high_first)));
  }
  const std::uint32_t bits = bits_of(words, true);
  double steps = bits;
  if (entry.type == RegisterType::kI32) steps = static_cast<double>(std::bit_cast<std::int32_t>(bits));
  if (entry.type == RegisterType::kI16) steps = static_cast<double>(std::bit_cast<std::int16_t>(words[0]));
  if (is_signed(entry.type) && steps < static_cast<double>(entry.lowest)) return kNaN;
  return steps * step_of(entry, options);
}

RegisterBlock encode_registers(const WireReport& report, const MetricValues& metrics, const ServerState& server,
                               const RegisterCodecOptions& options) noexcept {
  RegisterBlock block{};
  Writer out(block, options);
  put_state(out, report, server, options);
  put_pose(out, report);
  put_angles(out, report);
  put_others(out, report);
  put_metrics(block, metrics, options);
  out.put<reg::kProbeInt32>(-1);
  out.put<reg::kProbeWordOrder>(0x12345678);
  out.put<reg::kProbeFloat>(123456.0);
  put_commands(out, server.commands);
  put_identity(out, block, server.identity);
  return block;
}

double RegisterReader::value(std::uint16_t address) const noexcept {
  const RegisterEntry* entry = find_register(address);
  EXPECTS(entry != nullptr && address + std::size_t{entry->words()} <= registers_.size());
  return decode_value(*entry, registers_.subspan(address, entry->words()), options_);
}

std::uint32_t RegisterReader::integer(std::uint16_t address) const noexcept {
  const RegisterEntry* entry = find_register(address);
  EXPECTS(entry != nullptr && address + std::size_t{entry->words()} <= registers_.size());
  EXPECTS(!is_signed(entry->type) && entry->type != RegisterType::kF32);
  return bits_of(registers_.subspan(address, entry->words()), true);
}

std::string RegisterReader::board_serial() const {
  std::string text;
  for (std::size_t i = 0; i < kBoardSerialLength; ++i) {
    const std::uint32_t word = integer(static_cast<std::uint16_t>(reg::kBoardSerial + i / 2));
    const auto c = static_cast<unsigned char>(i % 2 == 0 ? word >> 8U : word & 0xFFU);
    if (c == 0) break;
    // It goes onto terminals and into JSON as it is.
    if (c < ' ' || c > '~' || c == '"' || c == '\\') return {};
    text += static_cast<char>(c);
  }
  return text;
}

}  // namespace ninedot
