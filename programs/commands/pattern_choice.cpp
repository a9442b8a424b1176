#include "programs/commands/pattern_choice.h"

#include <fmt/core.h>

#include <algorithm>
#include <charconv>
#include <optional>
#include <set>
#include <utility>

#include "base/startup_error.h"
#include "base/units.h"
#include "programs/assembly/localiser_options.h"
#include "world/landmark_codes.h"
#include "world/landmark_map.h"

namespace ninedot {
namespace {

[[noreturn]] void refuse(const std::string& line) { throw StartupError(ExitStatus::kWrongUsage, line); }

struct IdRange {
  int first = 0, last = 0;
};

/// "7" or "1-16"; nothing where it is neither.
std::optional<IdRange> parse_range(const std::string& word) {
  const char* const end = word.data() + word.size();
  IdRange range;
  const auto first = std::from_chars(word.data(), end, range.first);
  if (first.ec != std::errc{}) return std::nullopt;
  range.last = range.first;
  if (first.ptr == end) return range;
  if (*first.ptr != '-') return std::nullopt;
  const auto last = std::from_chars(first.ptr + 1, end, range.last);
  if (last.ec != std::errc{} || last.ptr != end || range.last < range.first) return std::nullopt;
  return range;
}

/// A sheet that somebody has hung by eye is out of upright by a degree or two, which a map made of pictures tells as an
/// orientation. Whoever hangs one by the list that leans by more would hang it wrong.
constexpr double kUpright_rad = 3 * kRadPerDeg;

/// Nothing: it hangs not upright, or nobody knows where.
std::optional<double> heading_deg(const MapLandmarkConfig& landmark) {
  if (!landmark.position_mm) return std::nullopt;
  if (!landmark.orientation_wxyz) return landmark.heading_deg;
  const Transform<frame::World, frame::Landmark> place = place_of(landmark);
  return lean_rad(place) < kUpright_rad ? std::optional(heading_rad(place) * kDegPerRad) : std::nullopt;
}

PatternOptions with_landmark(PatternOptions lengths, std::optional<int> id, std::string code) {
  lengths.landmark_id = id;
  lengths.code = std::move(code);
  return lengths;
}

}  // namespace

std::vector<PatternOptions> known_landmarks(const std::vector<std::string>& words, const PatternOptions& lengths) {
  std::vector<PatternOptions> landmarks;
  std::set<int> ids;
  for (const std::string& word : words) {
    const std::optional<IdRange> range = parse_range(word);
    if (!range)
      refuse(fmt::format("--id {}: give numbers, or the first and the last of a row, for example 1-16", word));
    for (const int id : {range->first, range->last})
      if (!known_code(id))
        refuse(fmt::format("--id {}: give 0, black and white, or 1 to {}; for another landmark give its --code", id,
                           kKnownCodes));
    for (int id = range->first; id <= range->last; ++id) {
      if (!ids.insert(id).second) refuse(fmt::format("--id {}: it is named twice: leave one of them out", id));
      landmarks.push_back(with_landmark(lengths, id, std::string(*known_code(id))));
    }
  }
  return landmarks;
}

PatternOptions landmark_of_code(const std::string& code, const PatternOptions& lengths) {
  return with_landmark(lengths, known_id(code), code);
}

std::vector<ListedLandmark> landmarks_of_map(const Config& config) {
  std::vector<ListedLandmark> list;
  for (const MapLandmarkConfig& landmark : config.landmarks)
    list.push_back({landmark.id, landmark.code, landmark.position_mm, heading_deg(landmark)});
  if (list.empty()) list.emplace_back();
  std::ranges::sort(list, {}, &ListedLandmark::landmark_id);
  return list;
}

std::vector<PatternOptions> listed_landmarks(const std::vector<ListedLandmark>& list, const PatternOptions& lengths) {
  std::vector<PatternOptions> landmarks;
  for (const ListedLandmark& listed : list)
    landmarks.push_back(with_landmark(lengths, listed.landmark_id, listed.code));
  return landmarks;
}

}  // namespace ninedot
