#include "programs/web/live_json.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <span>

#include "base/json_text.h"
#include "base/reason.h"
#include "base/refusal.h"

namespace ninedot {
namespace {

/// An object or an array in the making.
class Json {
 public:
  explicit Json(char open = '{') : text_(1, open), close_(open == '{' ? '}' : ']') {}
  Json& raw(std::string_view key, std::string_view value) {
    if (text_.size() > 1) text_ += ',';
    if (!key.empty()) fmt::format_to(std::back_inserter(text_), "\"{}\":", key);
    text_ += value;
    return *this;
  }
  Json& number(std::string_view key, double value) {
    return raw(key, std::isfinite(value) ? fmt::format("{:.9g}", value) : "null");
  }
  Json& integer(std::string_view key, std::uint64_t value) { return raw(key, fmt::format("{}", value)); }
  Json& flag(std::string_view key, bool value) { return raw(key, value ? "true" : "false"); }
  Json& text(std::string_view key, std::string_view value) { return raw(key, json_text(value)); }
  template <typename Numbers>
  Json& numbers(std::string_view key, const Numbers& values) {
    Json list('[');
    for (const auto value : values) list.number("", static_cast<double>(value));
    return raw(key, list.done());
  }
  std::string done() const { return text_ + close_; }

 private:
  std::string text_;
  char close_;
};

double ms(std::int64_t ns) { return static_cast<double>(ns) / 1e6; }

template <std::size_t N>
std::string_view text_of(const std::array<char, N>& text) {
  return {text.data(), static_cast<std::size_t>(std::find(text.begin(), text.end(), '\0') - text.begin())};
}

std::string pose_json(const TapPose& pose) {
  return Json()
      .numbers("mm", pose.position_mm)
      .numbers("q", pose.quaternion_wxyz)
      .numbers("sigma_mm", pose.sigma_mm)
      .numbers("sigma_deg", pose.sigma_deg)
      .done();
}

std::string landmark_json(const TapLandmark& landmark) {
  Json candidates('[');
  for (std::uint32_t i = 0; i < std::min<std::uint32_t>(landmark.candidate_count, kTapCandidateCount); ++i) {
    const TapCandidate& candidate = landmark.candidates[i];
    candidates.raw("", Json()
                           .numbers("mm", candidate.position_mm)
                           .numbers("q", candidate.quaternion_wxyz)
                           .number("chi2", candidate.chi2_above)
                           .number("rms_px", candidate.rms_px)
                           .done());
  }
  return Json()
      .integer("id", landmark.id)
      .integer("reason", landmark.reason)
      .text("why", reason_sentence(landmark.reason))
      .integer("quality", landmark.quality)
      .integer("dots", landmark.dots_used)
      .integer("chosen", landmark.chosen)
      .number("rival", landmark.rival_odds)
      .raw("candidates", candidates.done())
      .done();
}

std::string dots_json(std::span<const TapDot> list) {
  Json dots('[');
  for (const TapDot& dot : list)
    dots.numbers(
        "", std::array{dot.u_px, dot.v_px, dot.semi_major_px, dot.semi_minor_px, dot.angle_deg, dot.visible_fraction});
  return dots.done();
}

/// To a tenth of a pixel, for eyes: hundreds of them come with each frame that shows no landmark.
std::string spots_json(std::span<const TapSpot> list) {
  Json spots('[');
  for (const TapSpot& spot : list) {
    const std::array ellipse{spot.u_px, spot.v_px, spot.semi_major_px, spot.semi_minor_px, spot.angle_deg};
    if (std::ranges::all_of(ellipse, [](float value) { return std::isfinite(value); }))
      spots.raw("", fmt::format("[{:.1f}]", fmt::join(ellipse, ",")));
  }
  return spots.done();
}

std::string search_json(const TapSearch& search) {
  return Json()
      .integer("refusal", search.refusal)
      .text("why", refusal_sentence(search.refusal))
      .number("contrast", search.contrast_lsb)
      .number("noise", search.noise_lsb)
      .raw("dots", dots_json(search.dots))
      .integer("spots_seen", search.spots_seen)
      .raw("spots", spots_json(std::span(search.spots).first(std::min<std::size_t>(search.spot_count, kTapSpotCount))))
      .done();
}

std::string cuts_json(const TapFrame& frame) {
  return Json()
      .integer("runs", frame.runs_cut)
      .integer("blobs", frame.blobs_cut)
      .integer("neighbours", frame.neighbours_cut)
      .integer("hypotheses", frame.hypotheses_cut)
      .integer("frames", frame.frames_cut)
      .done();
}

std::string head_json(const TapFrame& frame) {
  const auto has = [&](std::uint32_t flag) { return (frame.flags & flag) != 0; };
  return Json()
      .number("pan_deg", frame.head_pan_deg)
      .number("tilt_deg", frame.head_tilt_deg)
      .flag("limit", has(tap_flag::kHeadLimit))
      .flag("fault", has(tap_flag::kHeadFault))
      .flag("inhibited", has(tap_flag::kHeadInhibited))
      .done();
}

}  // namespace

std::string camera_json(const TapHeader& header) {
  return Json()
      .text("software", text_of(header.software))
      .number("started_ms", ms(header.started_at_ns))
      .integer("process", header.process_id)
      .integer("width", header.width_px)
      .integer("height", header.height_px)
      .integer("lens", header.lens_model)
      .numbers("intrinsics", header.intrinsics_px)
      .numbers("distortion", header.distortion)
      .number("ring_mm", header.ring_radius_mm)
      .number("dot_mm", header.dot_radius_mm)
      .number("centre_mm", header.centre_radius_mm)
      .number("rate_hz", header.rate_hz)
      .done();
}

std::string frame_json(const TapFrame& frame, MonoTime now) {
  const auto has = [&](std::uint32_t flag) { return (frame.flags & flag) != 0; };
  Json landmarks('[');
  for (std::uint32_t i = 0; i < std::min<std::uint32_t>(frame.landmark_count, kTapLandmarkCount); ++i)
    landmarks.raw("", landmark_json(frame.landmarks[i]));
  Json json;
  json.integer("number", frame.number)
      .number("age_ms", frame.pose_exposed_at_ns == 0 ? NAN : ms(to_ns(now) - frame.pose_exposed_at_ns))
      .number("at_ms", ms(frame.exposed_at_ns))
      .number("latency_ms", ms(frame.latency_ns))
      .number("process_ms", ms(frame.process_ns))
      .number("exposure_ms", ms(frame.exposure_ns))
      .flag("valid", has(tap_flag::kValid))
      .flag("found", has(tap_flag::kFound))
      .flag("ambiguous", has(tap_flag::kAmbiguous))
      .flag("has_pose", has(tap_flag::kHasPose))
      .flag("calibrated", has(tap_flag::kCalibrated))
      .flag("tracking", has(tap_flag::kTracking))
      .flag("ellipse", has(tap_flag::kEllipseSolver))
      .flag("dots_from_pose", has(tap_flag::kDotsFromPose))
      .integer("reason", frame.reason)
      .text("why", reason_sentence(frame.reason))
      .integer("landmark", frame.landmark_id)
      .integer("quality", frame.quality)
      .integer("dots_used", frame.dots_used)
      .integer("processed", frame.frames_processed)
      .integer("dropped", frame.frames_dropped)
      .integer("failed", frame.frames_failed)
      .number("rms_px", frame.rms_px)
      .number("ambiguity", frame.ambiguity)
      .number("distance_mm", frame.distance_mm)
      .number("tilt_deg", frame.tilt_deg)
      .raw("in_landmark", pose_json(frame.camera_in_landmark))
      .raw("in_world", pose_json(frame.camera_in_world))
      .raw("body", pose_json(frame.body_in_world))
      .raw("dots", dots_json(frame.dots))
      .raw("landmarks", landmarks.done())
      .integer("seen", frame.landmarks_seen)
      .integer("rejected", frame.landmarks_rejected)
      .raw("cut", cuts_json(frame))
      .numbers("latency_bins", frame.latency_bins);
  if (has(tap_flag::kHasTrack))
    json.raw("track", pose_json(frame.track)).numbers("velocity_mm_s", frame.track_velocity_mm_s);
  if (frame.search.has_failed != 0) json.raw("search", search_json(frame.search));
  if (has(tap_flag::kHasHead)) json.raw("head", head_json(frame));
  return json.done();
}

std::string service_json(const TapService& service, MonoTime now) {
  Json clients('['), log('[');
  for (std::uint32_t i = 0; i < service.client_count; ++i) {
    const TapClient& client = service.clients[i];
    clients.raw("", Json()
                        .text("address", text_of(client.address))
                        .integer("requests", client.requests)
                        .number("connected_ms", ms(client.connected_ns))
                        .number("silent_ms", ms(client.silent_ns))
                        .done());
  }
  const std::uint64_t first = service.log_count > kTapLogCount ? service.log_count - kTapLogCount : 0;
  for (std::uint64_t line = first; line < service.log_count; ++line) {
    const TapLogLine& from = service.log[line % kTapLogCount];
    log.raw("", Json().number("ago_ms", ms(to_ns(now) - from.at_ns)).text("text", text_of(from.text)).done());
  }
  return Json()
      .number("age_ms", ms(to_ns(now) - service.written_at_ns))
      .number("step_mm", service.position_step_mm)
      .flag("float_low_first", service.float_low_first != 0)
      .flag("over", service.frame_loop_over != 0)
      .numbers("registers", std::span(service.registers).first(service.register_count))
      .raw("clients", clients.done())
      .raw("log", log.done())
      .done();
}

std::string map_json(const Config& config) {
  Json list('[');
  for (const MapLandmarkConfig& landmark : config.landmarks) {
    if (!landmark.position_mm && config.landmarks.size() > 1) continue;
    Json one;
    one.integer("id", static_cast<std::uint64_t>(landmark.id)).text("code", landmark.code);
    one.numbers("mm", landmark.position_mm.value_or(std::array<double, 3>{}));
    one.number("heading_deg", landmark.heading_deg);
    if (landmark.orientation_wxyz) one.numbers("q", *landmark.orientation_wxyz);
    one.numbers("sigma_mm", landmark.sigma_position_mm);
    list.raw("", one.done());
  }
  if (config.landmarks.empty())
    list.raw(
        "",
        Json().integer("id", 0).text("code", "").numbers("mm", std::array{0, 0, 0}).number("heading_deg", 0).done());
  return list.done();
}

std::string landmarks_json(const Config& config) {
  Json list('[');
  for (const MapLandmarkConfig& landmark : config.landmarks) {
    Json one;
    one.integer("id", static_cast<std::uint64_t>(landmark.id)).text("code", landmark.code);
    one.flag("placed", landmark.position_mm.has_value());
    one.flag("measured", landmark.position_mm.has_value() && !landmark.from_pictures);
    list.raw("", one.done());
  }
  return list.done();
}

}  // namespace ninedot
