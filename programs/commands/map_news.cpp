#include "programs/commands/map_news.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "base/json_text.h"
#include "base/units.h"
#include "programs/commands/map_findings.h"

namespace ninedot {
namespace {

/// Of the lines, for a page: the first so many.
constexpr std::size_t kMostLines = 50;

std::string placed_json(const BuiltMap& map, const MapStart& start) {
  std::string json;
  for (std::size_t i = 0; i < map.placed.size(); ++i) {
    const MappedLandmark& one = map.placed[i];
    const Eigen::Vector3d mm = one.T_world_landmark.translation_m / kMetresPerMm;
    const Eigen::Quaterniond q = one.T_world_landmark.quaternion();
    const Eigen::Vector3d sigma_mm = one.covariance.diagonal().head<3>().cwiseSqrt() / kMetresPerMm;
    const double sigma_deg = std::sqrt(one.covariance.diagonal().tail<3>().maxCoeff()) * kDegPerRad;
    const char* const how = start.is_exact(one.id) ? "given" : start.is_given(one.id) ? "joined" : "found";
    json += fmt::format(
        R"({}{{"id":{},"mm":[{:.2f},{:.2f},{:.2f}],"q":[{:.5f},{:.5f},{:.5f},{:.5f}],"sigma_mm":[{:.3g},{:.3g},{:.3g}],"sigma_deg":{:.3g},"sightings":{},"how":"{}","new":{}}})",
        json.empty() ? "" : ",", one.id, mm.x(), mm.y(), mm.z(), q.w(), q.x(), q.y(), q.z(), sigma_mm.x(), sigma_mm.y(),
        sigma_mm.z(), sigma_deg, map.sighting_counts[i], how, start.is_added(one.id));
  }
  return json;
}

}  // namespace

void MapNews::reading(const MapReading& reading) {
  say(fmt::format(R"({{"state":"reading","look":{},"recording":{},"recordings":{},"frame":{},"frames":{}}})",
                  reading.look, reading.recording, reading.recordings, reading.frame, reading.frames));
}

void MapNews::done(const BuiltMap& map, const MapStart& start, const std::vector<std::string>& lines,
                   const std::string& out, const std::string& plan) {
  std::vector<std::string> told(lines.begin(),
                                lines.begin() + static_cast<std::ptrdiff_t>(std::min(lines.size(), kMostLines)));
  if (told.size() < lines.size()) told.push_back(fmt::format("and {} lines more", lines.size() - told.size()));
  say(fmt::format(R"({{"state":"done","summary":{},"wish":{},"placed":[{}],"lines":{},"file":{},"plan":{}}})",
                  json_text(map_summary(map, start)), json_text(map_wish(map)), placed_json(map, start),
                  texts_json(told), json_text(out), json_text(plan)));
}

}  // namespace ninedot
