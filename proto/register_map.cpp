#include "proto/register_map.h"

#include <array>

#include "base/aim_state.h"
#include "base/reason.h"

namespace ninedot {
namespace {

constexpr bool map_is_well_formed() {
  std::uint32_t next_free = 0;
  for (const RegisterEntry& entry : kRegisterMap) {
    if (entry.address < next_free) return false;  // out of order, or on top of the one before
    next_free = std::uint32_t{entry.address} + entry.words();
    if (next_free > kRegisterCount || entry.name.empty() || entry.meaning.empty() || entry.scale <= 0) return false;
    if (entry.type != RegisterType::kF32 && entry.lowest >= entry.highest) return false;
  }
  return true;
}
static_assert(map_is_well_formed());

constexpr RegisterBit kStatusBitTable[] = {
    {status_bit::kValid, "valid", "the pose is of the newest frame, usable and not stale"},
    {status_bit::kFound, "found", "the newest frame shows a landmark"},
    {status_bit::kAmbiguous, "ambiguous",
     "the newest frame shows a landmark that can be read in two ways: never together with valid"},
    {status_bit::kStale, "stale", "the pose is older than the limit, or there has been none yet"},
    {status_bit::kCalibrated, "calibrated", "a calibration of the camera is loaded"},
    {status_bit::kServoLimit, "servo_limit", "the head stands at the end of its range (0 without a head)"},
    {status_bit::kThrottled, "throttled", "the board runs slower because of heat or supply (0 where unknown)"},
    {status_bit::kTracking, "tracking", "found where it was expected, without a search of the whole picture"},
    {status_bit::kEllipseSolver, "ellipse_solver", "the pose is from the solver \"ellipse\", not \"full\""},
    {status_bit::kHeld, "held", "this client holds the data block (register 104)"},
    {status_bit::kWritesEnabled, "writes_enabled", "function codes 06 and 16 are accepted"},
    {status_bit::kInhibited, "inhibited", "the inhibit input keeps the head where it is"},
    {status_bit::kServoFault, "servo_fault", "the head could not be moved, or does not answer"},
    {status_bit::kHasHead, "has_head", "there is a pan/tilt head: registers 37 and 38 are its angles"},
};

constexpr auto kHealthBitTable = [] {
  std::array<RegisterBit, kMetricCount - (kRegisterMap.size() - kOwnRegisters.size())> bits{};
  auto* to = bits.begin();
  for (const Metric& metric : kMetrics)
    if (metric.kind == MetricKind::kFlag) *to++ = {metric.address, metric.name, metric.meaning};
  return bits;
}();

constexpr auto kReasonTable = [] {
  std::array<RegisterCode, kReasons.size()> codes{};
  for (std::size_t i = 0; i < codes.size(); ++i)
    codes[i] = {static_cast<std::uint16_t>(kReasons[i].reason), kReasons[i].sentence};
  return codes;
}();

// A code is what a client reads: name and words in one.
const std::array<std::string, kAimStateCount> kHeadStateTexts = [] {
  std::array<std::string, kAimStateCount> texts;
  for (std::size_t i = 0; i < kAimStateCount; ++i)
    texts[i] = std::string(kAimStates[i].name) + ": " + std::string(kAimStates[i].sentence);
  return texts;
}();
const auto kHeadStateTable = [] {
  std::array<RegisterCode, kAimStateCount> codes{};
  for (std::size_t i = 0; i < kAimStateCount; ++i)
    codes[i] = {static_cast<std::uint16_t>(kAimStates[i].state), kHeadStateTexts[i]};
  return codes;
}();

constexpr bool metrics_are_in_order() {
  for (std::size_t i = 0; i < kMetricCount; ++i)
    if (static_cast<std::size_t>(kMetrics[i].id) != i) return false;
  return true;
}
static_assert(metrics_are_in_order());

constexpr RegisterCode kPoseContentTable[] = {
    {0, "camera in the world: its optical centre, and what turns camera vectors into the world's"},
    {1, "camera in the frame of the landmark that register 6 names"},
    {2, "robot body in the world: its origin, and what turns body vectors (x forward, y left, z up) into the world's"},
};
constexpr RegisterCode kEulerTable[] = {
    {0,
     "yaw, pitch, roll: about z, the new y, the new x; of a body yaw is the heading, positive to the left, and a "
     "positive pitch looks down"},
    {1, "FANUC W, P, R: about the fixed x, y, z, in this order"},
    {2, "KUKA A, B, C: about z, the new y, the new x"},
};

constexpr std::uint16_t number(Command command) { return static_cast<std::uint16_t>(command); }
constexpr RegisterCode kCommandTable[] = {
    {number(Command::kNone), "nothing"},
    {number(Command::kFollow), "the head follows the landmark"},
    {number(Command::kPoint), "the head moves to the set-points (registers 105, 106) and stays there"},
    {number(Command::kPark), "the head moves to its parking place and stays there"},
};
static_assert(std::size(kCommandTable) == kLastCommand + 1U);

}  // namespace

const std::span<const RegisterBit> kStatusBits = kStatusBitTable;
const std::span<const RegisterBit> kHealthBits = kHealthBitTable;
const std::span<const RegisterCode> kReasonCodes = kReasonTable;
const std::span<const RegisterCode> kPoseContentCodes = kPoseContentTable;
const std::span<const RegisterCode> kHeadStateCodes = kHeadStateTable;
const std::span<const RegisterCode> kEulerCodes = kEulerTable;
const std::span<const RegisterCode> kCommandCodes = kCommandTable;

}  // namespace ninedot
