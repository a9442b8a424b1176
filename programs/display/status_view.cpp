#include "programs/display/status_view.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "base/aim_state.h"
#include "base/reason.h"

namespace ninedot {
namespace {

using Text = fmt::memory_buffer;

template <typename... Args>
void add(Text& text, fmt::format_string<Args...> format, Args&&... args) {
  fmt::format_to(std::back_inserter(text), format, std::forward<Args>(args)...);
}

/// "-123.4", or "?" for a value that the service does not know.
std::string number(double value, int digits) {
  return std::isfinite(value) ? fmt::format("{:.{}f}", value, digits) : std::string("?");
}

/// A register's value; NaN where it stands for "unknown": a measured quantity at the end of its range, or no landmark
/// yet. An age, an ambiguity and odds at their end are what they say.
double known_value(const RegisterReader& r, std::uint16_t address) {
  const RegisterEntry& entry = *find_register(address);
  const double value = r.value(address);
  const bool is_measured = entry.type == RegisterType::kU16 && entry.scale != 1 && address != reg::kAmbiguity &&
                           address != reg::kAge && address != reg::kRivalOdds;
  const bool has_end = is_measured || address == reg::kLandmarkId;
  return has_end && value >= static_cast<double>(entry.highest) * entry.scale ? std::numeric_limits<double>::quiet_NaN()
                                                                              : value;
}

std::string age_text(const RegisterReader& r) {
  const double age_ms = r.value(reg::kAge);
  return age_ms >= 6553 ? std::string("> 6.5 s") : fmt::format("{:.1f} ms", age_ms);
}

std::string state_text(const RegisterReader& r) {
  if (!r.status(status_bit::kValid)) return fmt::format("NOT VALID: {}", reason_sentence(r.integer(reg::kReason)));
  std::string text = "valid";
  if (r.status(status_bit::kTracking)) text += ", tracking";
  if (!r.status(status_bit::kCalibrated)) text += ", camera NOT CALIBRATED";
  if (r.status(status_bit::kHeld)) text += ", held by this client";
  return text;
}

/// Three values that lie `words` registers apart: "   123.456    -4.000     0.001".
std::string triple(const RegisterReader& r, std::uint16_t first, std::uint16_t words, int digits) {
  std::string text;
  for (std::uint16_t i = 0; i < 3; ++i)
    text += fmt::format("{:>12}", number(known_value(r, static_cast<std::uint16_t>(first + i * words)), digits));
  return text;
}

std::string uptime_text(std::uint32_t seconds) {
  return fmt::format("{}:{:02}:{:02}", seconds / 3600, seconds / 60 % 60, seconds % 60);
}

/// What the rotation turns: "camera to world".
std::string_view turn_of(const RegisterReader& r) {
  switch (static_cast<PoseContent>(r.integer(reg::kPoseContent))) {
    case PoseContent::kCameraInLandmark:
      return "camera to landmark";
    case PoseContent::kBodyInWorld:
      return "body to world";
    case PoseContent::kCameraInWorld:
      break;
  }
  return "camera to world";
}

std::string_view angle_names(const RegisterReader& r) {
  switch (static_cast<EulerConvention>(r.integer(reg::kEulerConvention))) {
    case EulerConvention::kFanuc:
      return "FANUC W, P, R";
    case EulerConvention::kKuka:
      return "KUKA A, B, C";
    case EulerConvention::kZyx:
      break;
  }
  return "yaw, pitch, roll";
}

/// "?" for what the service does not know: of unsigned registers that is the end of their range.
std::string metric_value(const RegisterReader& r, const Metric& metric) {
  if (metric.id == MetricId::kUptime) return uptime_text(r.integer(metric.address));
  const double value = r.value(metric.address);
  const RegisterEntry entry = register_of(metric);
  const bool is_unknown =
      metric.kind == MetricKind::kGauge && value >= static_cast<double>(entry.highest) * entry.scale;
  return is_unknown ? "?" : number(value, metric.decimals);
}

/// "1 client", "2 clients". \param words  "{} client(s)"
std::string in_number(std::string_view words, std::string_view value) {
  const std::size_t number = words.find("{}"), ending = std::min(words.find("(s)"), words.size());
  std::string text(words.substr(0, number));
  text += value;
  text += words.substr(number + 2, ending - number - 2);
  if (ending == words.size()) return text;
  if (value != "1") text += 's';
  text += words.substr(ending + 3);
  return text;
}

/// Nothing for a metric that is not shown now.
std::string metric_words(const RegisterReader& r, const Metric& metric) {
  if (metric.kind == MetricKind::kFlag) {
    const std::size_t bar = metric.words.find('|');
    const bool is_set = (r.integer(reg::kHealthFlags) & metric.address) != 0;
    return std::string(is_set ? metric.words.substr(0, bar) : metric.words.substr(bar + 1));
  }
  const double value = r.value(metric.address);
  if (!metric.always_shown && (value == 0 || std::isnan(value))) return {};
  return in_number(metric.words, metric_value(r, metric));
}

/// The metrics' rows: "name       one, another", broken before column 100.
void add_metric_rows(Text& text, const RegisterReader& r) {
  constexpr std::size_t kColumns = 100;
  std::string_view row;
  std::string line;
  const auto end_line = [&] {
    if (!line.empty()) add(text, "{}\n", line);
  };
  for (const Metric& metric : kMetrics) {
    const std::string words = metric_words(r, metric);
    if (words.empty()) continue;
    if (metric.row != row) {
      end_line();
      row = metric.row;
      line = fmt::format("{:<11}{}", row, words);
    } else if (line.size() + 2 + words.size() > kColumns - 1) {
      line += ',';
      end_line();
      line = fmt::format("{:<11}{}", "", words);
    } else {
      line += ", " + words;
    }
  }
  end_line();
}

std::string landmark_text(const RegisterReader& r) {
  const std::uint32_t id = r.integer(reg::kLandmarkId);
  return id == kNoLandmarkYet ? std::string("?") : fmt::format("{}", id);
}

std::string version_text(const RegisterReader& r) {
  return fmt::format("{}.{}.{}", r.integer(reg::kSoftwareMajor), r.integer(reg::kSoftwareMinor),
                     r.integer(reg::kSoftwarePatch));
}

void add_bit_names(Text& text, std::uint32_t value, std::span<const RegisterBit> bits) {
  const char* separator = "";
  add(text, "[");
  for (const RegisterBit& bit : bits) {
    if ((value & bit.mask) == 0) continue;
    add(text, "{}\"{}\"", separator, bit.name);
    separator = ",";
  }
  add(text, "]");
}

}  // namespace

RegisterReader make_reader(const RegisterBlock& registers) noexcept {
  constexpr double kProbe = 123456;  // what register probe_float always shows
  if (RegisterReader(registers).value(reg::kProbeFloat) == kProbe) return RegisterReader(registers);
  return RegisterReader(registers, {.float_word_order = WordOrder::kLowFirst});
}

std::string status_line(const RegisterReader& r) {
  Text text;
  if (r.status(status_bit::kValid)) {
    add(text, "x {} y {} z {} mm (1-sigma {} {} {}), {} dots, quality {}", number(known_value(r, reg::kX32), 1),
        number(known_value(r, reg::kX32 + 2), 1), number(known_value(r, reg::kX32 + 4), 1),
        number(known_value(r, reg::kSigmaX), 2), number(known_value(r, reg::kSigmaX + 1), 2),
        number(known_value(r, reg::kSigmaX + 2), 2), r.integer(reg::kDotsUsed), r.integer(reg::kQuality));
  } else {
    add(text, "no valid pose: {}", reason_sentence(r.integer(reg::kReason)));
  }
  add(text, "; {} Hz, latency {} ms (p99 {}), {} dropped, {}", number(known_value(r, reg::kFrameRate), 1),
      number(known_value(r, reg::kLatencyMedian), 1), number(known_value(r, reg::kLatencyP99), 1),
      r.integer(reg::kFramesDropped), in_number("{} client(s)", fmt::format("{}", r.integer(reg::kConnectedClients))));
  return fmt::to_string(text);
}

/// A newer service may have more of them than this program knows.
std::string head_state_name(const RegisterReader& r) {
  const std::uint32_t code = r.integer(reg::kHeadState);
  return code < kAimStateCount ? std::string(kAimStates[code].name) : fmt::format("state {}", code);
}

std::string status_table(const RegisterReader& r) {
  Text text;
  add(text, "pose       {} (landmark {}, quality {}/1000, age {})\n", state_text(r), landmark_text(r),
      r.integer(reg::kQuality), age_text(r));
  add(text, "                     x           y           z\n");
  add(text, "position  {} mm\n", triple(r, reg::kX32, 2, 3));
  add(text, "  1-sigma {} mm\n", triple(r, reg::kSigmaX, 1, 2));
  // Only where the calibration says how good it is.
  if (const double sigma_mm = known_value(r, reg::kSigmaCalibration); std::isfinite(sigma_mm))
    add(text, "  of these{:>12} mm are the calibration's, all axes together\n", number(sigma_mm, 2));
  add(text, "rotation  {} deg (rotation vector, {})\n", triple(r, reg::kRotationX32, 2, 3), turn_of(r));
  add(text, "  1-sigma {} deg\n", triple(r, reg::kSigmaRotationX, 1, 3));
  // Of a camera, whose z looks forward, they are no angles that a person reads.
  if (r.integer(reg::kPoseContent) != 0 || r.integer(reg::kEulerConvention) != 0) {
    add(text, "angles    {} deg ({})\n", triple(r, reg::kAngle32, 2, 3), angle_names(r));
    add(text, "  1-sigma {} deg\n", triple(r, reg::kSigmaAngle, 1, 3));
  }
  add(text, "landmark   {} of 9 dots, residual {} px, ambiguity {}, {} solver\n", r.integer(reg::kDotsUsed),
      number(known_value(r, reg::kResidual), 3), number(known_value(r, reg::kAmbiguity), 2),
      r.status(status_bit::kEllipseSolver) ? "ellipse" : "full");
  // In the newest frame; what stands above is of the newest valid one.
  if (r.value(reg::kRivalOdds) > 0)
    add(text, "or else    x {} y {} z {} mm, by another reading: odds {}\n", number(known_value(r, reg::kRivalX32), 1),
        number(known_value(r, reg::kRivalX32 + 2), 1), number(known_value(r, reg::kRivalX32 + 4), 1),
        number(r.value(reg::kRivalOdds), 3));
  if (r.value(reg::kLandmarksSeen) > 1 || r.value(reg::kLandmarksRejected) > 0)
    add(text, "in view    {} landmarks of the map{}\n", r.integer(reg::kLandmarksSeen),
        r.value(reg::kLandmarksRejected) > 0
            ? fmt::format(", {} NOT WHERE THE MAP SAYS (number {})", r.integer(reg::kLandmarksRejected),
                          r.integer(reg::kLastRejectedId))
            : "");
  if (r.value(reg::kLandmarksDisputed) > 1)
    add(text, "map        {} landmarks CONTRADICT each other (numbers {} and {}): measure them\n",
        r.integer(reg::kLandmarksDisputed), r.integer(reg::kDisputedId), r.integer(reg::kDisputedId + 1));
  else if (r.value(reg::kLandmarksDisputed) > 0)
    add(text, "map        landmark {} CONTRADICTED another one, which agrees with the others since: measure it\n",
        r.integer(reg::kDisputedId));
  if (r.status(status_bit::kHasHead))
    add(text, "head       {}, pan {} deg, tilt {} deg{}{}{}\n", head_state_name(r),
        number(known_value(r, reg::kPan), 2), number(known_value(r, reg::kTilt), 2),
        r.status(status_bit::kServoLimit) ? ", at its LIMIT" : "",
        r.status(status_bit::kInhibited) ? ", INHIBITED" : "",
        r.status(status_bit::kServoFault) ? ", does NOT ANSWER" : "");
  add_metric_rows(text, r);
  const std::string serial = r.board_serial();
  add(text, "device     ninedot {}{}\n", version_text(r),
      serial.empty() ? "" : ", serial number of the board " + serial);
  return fmt::to_string(text);
}

std::string status_json(const RegisterReader& r) {
  Text text;
  add(text, "{{\"reason_text\":\"{}\",\"head_state_text\":\"{}\"", reason_sentence(r.integer(reg::kReason)),
      head_state_name(r));
  add(text, ",\"software_version\":\"{}\",\"board_serial\":\"{}\"", version_text(r), r.board_serial());
  for (const RegisterEntry& entry : kRegisterMap) {
    if (entry.scale_is_configured) continue;  // a client does not know the scale; the 32-bit values say the same
    add(text, ",\"{}\":", entry.name);
    if (entry.address == reg::kStatus || entry.address == reg::kHealthFlags) {
      add_bit_names(text, r.integer(entry.address), entry.address == reg::kStatus ? kStatusBits : kHealthBits);
      continue;
    }
    const double value = known_value(r, entry.address);
    if (std::isfinite(value))
      add(text, "{:.10g}", value);
    else
      add(text, "null");
  }
  add(text, "}}");
  return fmt::to_string(text);
}

}  // namespace ninedot
