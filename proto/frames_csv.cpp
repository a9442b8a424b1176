#include "proto/frames_csv.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>

#include "base/one_line.h"

namespace ninedot {
namespace {

constexpr std::uint64_t kMaxFrame = 999'999'999;                      ///< a year at 30 Hz; keeps file names short
constexpr std::int64_t kMaxTimestamp_ns = 4'000'000'000'000'000'000;  ///< 126 years; leaves room to add to it
constexpr int kMaxZoom = 0xFFFF;                                      ///< what VISCA can say
constexpr std::array<std::string_view, 5> kColumns{"frame", "timestamp_ns", "pan_deg", "tilt_deg", "zoom"};
enum Column : std::size_t { kFrame, kTimestamp, kPan, kTilt, kZoom };
using Places = std::array<std::optional<std::size_t>, kColumns.size()>;

/// Cuts the next line off `text`, without its line feed.
std::string_view next_line(std::string_view& text) {
  const std::size_t end = text.find('\n');
  std::string_view line = text.substr(0, end);
  text = end == std::string_view::npos ? std::string_view{} : text.substr(end + 1);
  if (line.ends_with('\r')) line.remove_suffix(1);
  return line;
}

std::vector<std::string_view> split(std::string_view line) {
  std::vector<std::string_view> fields;
  for (;;) {
    const std::size_t comma = line.find(',');
    fields.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

template <typename Number>
std::optional<Number> parse_number(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::optional<double> parse_angle_deg(std::string_view text) {
  const std::optional<double> angle_deg = parse_number<double>(text);
  if (!angle_deg || !std::isfinite(*angle_deg) || std::abs(*angle_deg) > 360) return std::nullopt;
  return angle_deg;
}

/// As an error may show it, whatever file this is.
std::string quoted(std::string_view name) {
  constexpr std::size_t kMost = 40;
  return one_line(std::string(name.substr(0, kMost))) + (name.size() > kMost ? "..." : "");
}

/// Where each column is in a row. \return what is wrong with the header, empty = nothing
std::string read_header(const std::vector<std::string_view>& names, Places& places) {
  for (std::size_t i = 0; i < names.size(); ++i) {
    std::size_t column = 0;
    while (column < kColumns.size() && kColumns[column] != names[i]) ++column;
    if (column == kColumns.size())
      return fmt::format("unknown column '{}'; there are frame,timestamp_ns,pan_deg,tilt_deg,zoom", quoted(names[i]));
    if (places[column]) return fmt::format("column '{}' is there twice", names[i]);
    places[column] = i;
  }
  for (const Column needed : {kFrame, kTimestamp})
    if (!places[needed]) return fmt::format("column '{}' is missing", kColumns[needed]);
  return {};
}

/// \return what is wrong with the row, empty = nothing
std::string read_row(const std::vector<std::string_view>& fields, const Places& places, FramesCsvRow& row) {
  const std::optional<std::uint64_t> frame = parse_number<std::uint64_t>(fields[*places[kFrame]]);
  if (!frame || *frame > kMaxFrame) return "frame is not a whole number from 0 to 999999999";
  const std::optional<std::int64_t> timestamp_ns = parse_number<std::int64_t>(fields[*places[kTimestamp]]);
  if (!timestamp_ns || *timestamp_ns < 0 || *timestamp_ns > kMaxTimestamp_ns)
    return "timestamp_ns is not a whole number from 0 to 4000000000000000000";
  row = FramesCsvRow{*frame, *timestamp_ns, 0, 0, {}};
  if (places[kPan]) {
    const std::optional<double> pan_deg = parse_angle_deg(fields[*places[kPan]]);
    if (!pan_deg) return "pan_deg is not a number from -360 to 360";
    row.pan_deg = *pan_deg;
  }
  if (places[kTilt]) {
    const std::optional<double> tilt_deg = parse_angle_deg(fields[*places[kTilt]]);
    if (!tilt_deg) return "tilt_deg is not a number from -360 to 360";
    row.tilt_deg = *tilt_deg;
  }
  if (places[kZoom] && !fields[*places[kZoom]].empty()) {
    row.zoom = parse_number<int>(fields[*places[kZoom]]);
    if (!row.zoom || *row.zoom < 0 || *row.zoom > kMaxZoom) return "zoom is not a whole number from 0 to 65535";
  }
  return {};
}

}  // namespace

tl::expected<std::vector<FramesCsvRow>, TextError> parse_frames_csv(std::string_view text) {
  Places places;
  int line_number = 1;
  const auto error = [&](std::string what) { return tl::make_unexpected(TextError{line_number, std::move(what)}); };

  if (text.empty()) return error("the file is empty; write the header frame,timestamp_ns,pan_deg,tilt_deg");
  const std::vector<std::string_view> names = split(next_line(text));
  if (std::string what = read_header(names, places); !what.empty()) return error(std::move(what));

  std::vector<FramesCsvRow> rows;
  while (!text.empty()) {
    ++line_number;
    const std::vector<std::string_view> fields = split(next_line(text));
    if (fields.size() != names.size())
      return error(fmt::format("{} fields; the header has {}", fields.size(), names.size()));
    FramesCsvRow row;
    if (std::string what = read_row(fields, places, row); !what.empty()) return error(std::move(what));
    if (!rows.empty() && row.frame <= rows.back().frame) return error("frame does not grow");
    if (!rows.empty() && row.timestamp_ns <= rows.back().timestamp_ns) return error("timestamp_ns does not grow");
    rows.push_back(row);
  }
  return rows;
}

std::string format_frames_csv_row(const FramesCsvRow& row, bool with_zoom) {
  const std::string zoom = row.zoom ? fmt::format(",{}", *row.zoom) : ",";
  return fmt::format("{},{},{},{}{}\n", row.frame, row.timestamp_ns, row.pan_deg, row.tilt_deg, with_zoom ? zoom : "");
}

}  // namespace ninedot
