#pragma once
/// What the service counts and measures about itself: one table. The health registers, the lower half of
/// `ninedot status`, docs/registers.md and every later way to publish numbers follow from it.
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>

#include "proto/register_entry.h"

namespace ninedot {

enum class MetricKind : std::uint8_t {
  kCounter,  ///< only grows while the service runs; starts at 0 with it
  kGauge,    ///< what is true now; NaN: unknown
  kFlag,     ///< 0 or 1
};

/// In the order of the table.
enum class MetricId : std::uint8_t {
  kFrameRate,
  kFramesProcessed,
  kFramesDropped,
  kFramesFailed,
  kCameraRestarts,
  kLatencyMedian,
  kLatencyP99,
  kLatencyP999,
  kLatencyMax,
  kUptime,
  kRealtime,
  kMemoryLocked,
  kTemperature,
  kConnectedClients,
  kBusErrors,
  kExceptions,
  kRequests,
  kConnections,
  kConnectionsRefused,
  kConnectionsExpired,
  kForeignFrames,
  kSerialLosses,
  kSerialOpen,
  kHeadLosses,
  kServoSupply,
  kServoTemperature,
  kServoLoad,
  kPulseErrorP99,
  kPulseErrorMax,
  kRunsCut,
  kBlobsCut,
  kHypothesesCut,
  kNeighboursCut,
  kFramesCut,
  kRowTime,
  kRowTimeSigma,
  kRowTimeWrong,
  kCount,
};
inline constexpr std::size_t kMetricCount = static_cast<std::size_t>(MetricId::kCount);

struct Metric {
  MetricId id;
  std::string_view name;  ///< of the register, in JSON, and everywhere else
  std::string_view unit;  ///< empty: a plain number
  MetricKind kind;
  std::uint16_t address;     ///< its register; kFlag: its bit in register `health_flags`
  RegisterType type;         ///< kU16, kI16, kU32: saturates; kCounter32: wraps; kFlag: kBits16
  double step;               ///< one step of the register, in `unit`
  std::string_view counted;  ///< where: the part of the service that counts or measures it
  std::string_view row;      ///< of the table that people see
  std::string_view
      words;  ///< there: "{}" is the value, "(s)" an s unless that is 1; a flag: "when set|when not"; empty: not shown
  int decimals;       ///< there
  bool always_shown;  ///< false: only while it is known and not 0
  std::string_view meaning;
};

// clang-format off
inline constexpr auto kMetrics = [] {
  using enum MetricKind;
  using enum RegisterType;
  using Id = MetricId;
  return std::to_array<Metric>({
  {Id::kFrameRate,         "frame_rate",          "Hz",   kGauge,   60,      kU16,       0.1, "frame loop",     "frames",  "{} Hz", 1, true, "processed frames per second, over the last second; 0 when none come"},
  {Id::kFramesProcessed,   "frames_processed",    "",     kCounter, 61,      kCounter32, 1,   "frame loop",     "frames",  "{} processed", 0, true, "since the start, landmark or not; unless held, register 2 is its low half"},
  {Id::kFramesDropped,     "frames_dropped",      "",     kCounter, 63,      kCounter32, 1,   "camera source",  "frames",  "{} dropped", 0, true, "lost between the sensor and the frame loop"},
  {Id::kFramesFailed,      "frames_failed",       "",     kCounter, 65,      kCounter32, 1,   "frame loop",     "frames",  "{} failed", 0, true, "arrived, but unreadable or of a wrong size"},
  {Id::kCameraRestarts,    "camera_restarts",     "",     kCounter, 67,      kU16,       1,   "camera source",  "frames",  "{} camera restart(s)", 0, true, "the camera was closed and opened again"},
  {Id::kLatencyMedian,     "latency_median",      "ms",   kGauge,   68,      kU16,       0.1, "frame loop",     "latency", "median {} ms", 1, true, "of the capture-to-publish latency, since the start"},
  {Id::kLatencyP99,        "latency_p99",         "ms",   kGauge,   69,      kU16,       0.1, "frame loop",     "latency", "p99 {}", 1, true, "the same, 99 %"},
  {Id::kLatencyP999,       "latency_p999",        "ms",   kGauge,   70,      kU16,       0.1, "frame loop",     "latency", "p99.9 {}", 1, true, "the same, 99.9 %"},
  {Id::kLatencyMax,        "latency_max",         "ms",   kGauge,   71,      kU16,       0.1, "frame loop",     "latency", "max {} (capture to report)", 1, true, "the same, largest"},
  {Id::kUptime,            "uptime",              "s",    kCounter, 73,      kU32,       1,   "frame loop",     "service", "up {}", 0, true, "since the service started"},
  {Id::kRealtime,          "realtime",            "",     kFlag,    1U << 0, kBits16,    1,   "frame loop",     "service", "real-time|NOT real-time", 0, true, "the frame loop runs under SCHED_FIFO"},
  {Id::kMemoryLocked,      "memory_locked",       "",     kFlag,    1U << 1, kBits16,    1,   "service",        "service", "memory locked|memory NOT locked", 0, true, "the service's memory is locked"},
  {Id::kTemperature,       "temperature",         "degC", kGauge,   72,      kI16,       0.1, "service",        "service", "board {} degC", 1, true, "of the board; -32768 where unknown"},
  {Id::kConnectedClients,  "connected_clients",   "",     kGauge,   77,      kU16,       1,   "Modbus servers", "Modbus",  "{} connected", 0, true, "TCP connections, and one for a serial line heard in the last 5 s"},
  {Id::kBusErrors,         "bus_errors",          "",     kCounter, 75,      kU32,       1,   "Modbus servers", "Modbus",  "{} bus error(s)", 0, true, "bad check sums, broken frames, serial line lost"},
  {Id::kExceptions,        "exceptions",          "",     kCounter, 79,      kU16,       1,   "Modbus servers", "Modbus",  "{} exception(s) answered", 0, true, "requests answered with an exception"},
  {Id::kRequests,          "requests",            "",     kCounter, 88,      kCounter32, 1,   "Modbus servers", "Modbus",  "{} request(s)", 0, true, "complete requests of all clients"},
  {Id::kConnections,       "connections",         "",     kCounter, 90,      kCounter32, 1,   "Modbus TCP",     "Modbus",  "{} connection(s) since the start", 0, false, "TCP connections accepted"},
  {Id::kConnectionsRefused,"connections_refused", "",     kCounter, 92,      kCounter32, 1,   "Modbus TCP",     "Modbus",  "{} REFUSED", 0, false, "TCP connections refused: not on the list, or no place"},
  {Id::kConnectionsExpired,"connections_expired", "",     kCounter, 94,      kCounter32, 1,   "Modbus TCP",     "Modbus",  "{} expired", 0, false, "TCP connections that the service closed: idle, not reading its replies, displaced"},
  {Id::kForeignFrames,     "foreign_frames",      "",     kCounter, 96,      kCounter32, 1,   "Modbus RTU",     "Modbus",  "{} frame(s) of other units", 0, false, "frames of other units on the serial line"},
  {Id::kSerialLosses,      "serial_losses",       "",     kCounter, 98,      kU16,       1,   "Modbus RTU",     "Modbus",  "serial line LOST {} times", 0, false, "the serial device vanished"},
  {Id::kSerialOpen,        "serial_open",         "",     kFlag,    1U << 2, kBits16,    1,   "Modbus RTU",     "Modbus",  "serial line open|", 0, true, "the serial line is configured and open"},
  {Id::kHeadLosses,        "head_losses",         "",     kCounter, 99,      kU16,       1,   "head",           "servos",  "head LOST {} times", 0, false, "the head fell silent, or its line vanished"},
  {Id::kServoSupply,       "servo_supply",        "V",    kGauge,   159,     kI16,       0.01,"head",           "servos",  "{} V", 1, false, "smart servos: the lower of both supplies; -32768 where unknown, or while they do not answer"},
  {Id::kServoTemperature,  "servo_temperature",   "degC", kGauge,   160,     kI16,       0.1, "head",           "servos",  "{} degC", 0, false, "the same: the warmer servo"},
  {Id::kServoLoad,         "servo_load",          "%",    kGauge,   161,     kI16,       0.1, "head",           "servos",  "load {} %", 0, false, "the same: the harder working one, of the largest torque that it can give"},
  {Id::kPulseErrorP99,     "pulse_error_p99",     "us",   kGauge,   86,      kU16,       1,   "head",           "servos",  "pulses off by {} us (p99)", 0, false, "software-made servo pulses: error of their width, 99 %; 0 where hardware makes them"},
  {Id::kPulseErrorMax,     "pulse_error_max",     "us",   kGauge,   87,      kU16,       1,   "head",           "servos",  "max {}", 0, false, "the same, largest"},
  {Id::kRunsCut,           "runs_cut",            "",     kCounter, 108,     kCounter32, 1,   "detector",       "search",  "{} run(s) cut", 0, false, "rows of dark pixels that the search left out because its list was full"},
  {Id::kBlobsCut,          "blobs_cut",           "",     kCounter, 110,     kCounter32, 1,   "detector",       "search",  "{} blob(s) cut", 0, false, "the same for dark spots"},
  {Id::kHypothesesCut,     "hypotheses_cut",      "",     kCounter, 112,     kCounter32, 1,   "detector",       "search",  "{} hypotheses cut", 0, false, "the same for groups of dots that might be a landmark"},
  {Id::kNeighboursCut,     "neighbours_cut",      "",     kCounter, 114,     kCounter32, 1,   "detector",       "search",  "{} neighbour(s) cut", 0, false, "the same for dots near a dot"},
  {Id::kFramesCut,         "frames_cut",          "",     kCounter, 116,     kCounter32, 1,   "detector",       "search",  "{} frame(s) searched in part", 0, false, "frames that held more than is searched in one: the next one's search went on with it"},
  {Id::kRowTime,           "row_time",            "us",   kGauge,   162,     kI16,       0.01,"frame loop",     "shutter", "{} us from row to row", 2, false, "from one row's exposure to the next one's, as poses are made with it; -32768 where unknown"},
  {Id::kRowTimeSigma,      "row_time_sigma",      "us",   kGauge,   163,     kI16,       0.01,"frame loop",     "shutter", "1-sigma {}", 2, false, "the same, 1-sigma: 0 where `camera.row_time_us` says it; -32768 where unknown"},
  {Id::kRowTimeWrong,      "row_time_wrong",      "",     kFlag,    1U << 3, kBits16,    1,   "frame loop",     "shutter", "camera.row_time_us is WRONG|", 0, false, "moving landmarks show another row time than `camera.row_time_us`: poses are made with theirs"},
  });
}();
// clang-format on
static_assert(kMetrics.size() == kMetricCount);

/// The register that shows a metric. \param metric  no flag (contract): flags share register `health_flags`
constexpr RegisterEntry register_of(const Metric& metric) noexcept {
  using namespace register_ranges;
  const bool is_signed = metric.type == RegisterType::kI16;
  const std::int64_t highest = is_signed ? kI16Max : metric.type == RegisterType::kU16 ? kU16Max : kU32Max;
  return {metric.address,           metric.name, metric.type,           metric.step,   metric.unit,
          is_signed ? -highest : 0, highest,     RegisterAccess::kRead, metric.meaning};
}

constexpr const Metric& metric_of(MetricId id) noexcept { return kMetrics[static_cast<std::size_t>(id)]; }

/// One value per metric, in its unit: 0 until it is set. Counters up to 2^53. Memory: inside. Threads: one.
class MetricValues {
 public:
  constexpr double& operator[](MetricId id) noexcept { return values_[static_cast<std::size_t>(id)]; }
  constexpr double operator[](MetricId id) const noexcept { return values_[static_cast<std::size_t>(id)]; }

 private:
  std::array<double, kMetricCount> values_{};
};

}  // namespace ninedot
