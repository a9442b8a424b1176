#include "programs/commands/map_findings.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <utility>

#include "base/units.h"
#include "world/landmark_codes.h"

namespace ninedot {
namespace {

/// A pixel from the first to the last row of a usual rolling shutter, 16 ms.
constexpr double kMoving_px_s = 60;

/// More than these few pictures of one landmark are counted, not named.
constexpr std::size_t kNamedFrames = 5;

const char* plural(std::size_t count) { return count == 1 ? "picture" : "pictures"; }

void add_disagreeing(const BuiltMap& map, std::span<const std::string> recordings, std::vector<std::string>& lines) {
  std::map<std::pair<std::uint16_t, std::size_t>, std::vector<std::uint64_t>> disagreeing;
  for (const DisagreeingSighting& sighting : map.disagreeing)
    disagreeing[{sighting.id, sighting.recording}].push_back(sighting.frame);
  for (const auto& [where, frames] : disagreeing) {
    const std::vector<std::uint64_t> named(
        frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(std::min(frames.size(), kNamedFrames)));
    lines.push_back(fmt::format("landmark {} disagrees with the rest in {} {} of {} ({}{}) and was left out there",
                                where.first, frames.size(), plural(frames.size()), recordings[where.second],
                                fmt::join(named, ", "), named.size() < frames.size() ? ", ..." : ""));
  }
}

void add_unplaced(const BuiltMap& map, const MapStart& start, const SeenLandmarks& seen,
                  std::vector<std::string>& lines) {
  for (const std::uint16_t id : map.unseen)
    if (!start.is_added(id))
      lines.push_back(fmt::format("landmark {} is not placed: no picture shows it{}", id,
                                  seen.pictures.contains(id) ? " beside another one" : ""));
    else if (seen.pictures.contains(id))
      lines.push_back(
          fmt::format("landmark {}, which the configuration does not have, may be there: no picture shows "
                      "it beside another one",
                      id));
  for (const std::vector<std::uint16_t>& island : map.islands)
    lines.push_back(
        fmt::format("not placed: {}: take two pictures at least that show one of them beside one that is placed",
                    fmt::join(island, ", ")));
}

/// Those of the dictionary that could not keep their ids.
void add_renamed(const BuiltMap& map, const MapStart& start, std::vector<std::string>& lines) {
  for (const MappedLandmark& landmark : map.placed) {
    if (!start.is_added(landmark.id) || known_code(landmark.id)) continue;
    int known = 1;
    while (known < kKnownCodes && known_code(known) != landmark.code) ++known;
    lines.push_back(
        fmt::format("landmark {} is the sheet of `ninedot pattern --id {}`, an id that the configuration gives to "
                    "another code",
                    landmark.id, known));
  }
}

}  // namespace

std::string why_no_map(const SeenLandmarks& seen, const MapStart& start) {
  if (seen.pictures.empty())
    return "no landmark could be placed: no picture shows one of the configuration's; are these its codes, and is the "
           "picture sharp, and in colour?";
  if (seen.together.empty()) {
    std::vector<std::uint16_t> ids;
    for (const auto& [id, pictures] : seen.pictures) ids.push_back(id);
    return fmt::format(
        "no landmark could be placed: no picture shows two landmarks together, seen one at a time: {}; record so that "
        "each is in a picture with a neighbour",
        fmt::join(ids, ", "));
  }
  const auto is_given = [&](std::uint16_t id) { return start.is_given(id); };
  if (std::ranges::none_of(seen.together, is_given))
    return fmt::format(
        "no landmark could be placed: no two pictures show landmark {} beside another one; together are seen: {}",
        start.origin(), fmt::join(seen.together, ", "));
  return fmt::format("no landmark could be placed: no two pictures show landmark {} beside another one",
                     start.origin());
}

std::vector<std::string> map_findings(const BuiltMap& map, const MapStart& start, const SeenLandmarks& seen,
                                      std::span<const std::string> recordings) {
  std::vector<std::string> lines;
  for (std::size_t i = 0; i < recordings.size(); ++i)
    if (seen.joining[i] == 0)
      lines.push_back(fmt::format("{}: no picture shows two landmarks together: it adds nothing", recordings[i]));
  add_disagreeing(map, recordings, lines);
  for (const std::uint16_t id : map.disagreeing_surveys)
    lines.push_back(fmt::format("landmark {}: the pictures contradict its surveyed place, which was not used", id));
  add_renamed(map, start, lines);
  add_unplaced(map, start, seen, lines);
  if (!start.config.camera.row_time_us && seen.speed_px_s > kMoving_px_s)
    lines.push_back(
        fmt::format("the camera moves (landmarks by {:.0f} px/s), and camera.row_time_us is not told: if its shutter "
                    "rolls the map is wrong; `ninedot calibrate rolling-shutter` finds it, 0 is a global one",
                    seen.speed_px_s));
  if (map.variance_factor > 1.5)
    lines.push_back(
        fmt::format("the sightings spread {:.1f} times as widely as they say, and sigmas were enlarged by "
                    "that: is it the right calibration, and were the sheets flat and still?",
                    std::sqrt(map.variance_factor)));
  return lines;
}

std::string map_summary(const BuiltMap& map, const MapStart& start) {
  return fmt::format("{} of {} landmarks placed, from {} sightings in {} pictures", map.placed.size(),
                     landmarks_of_map(map, start).size(), map.sightings, map.frames);
}

std::string map_wish(const BuiltMap& map) {
  if (!map.weakest) return {};
  const double sigma_mm = map.weakest->sigma_m / kMetresPerMm;
  const std::string certain = sigma_mm < 10 ? fmt::format("{:.2g}", sigma_mm) : fmt::format("{:.0f}", sigma_mm);
  return fmt::format("a picture that shows {} and {} together would help most: they are certain to {} mm",
                     map.weakest->a, map.weakest->b, certain);
}

}  // namespace ninedot
