#include "programs/commands/map_start.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <optional>
#include <utility>

#include "base/startup_error.h"
#include "base/units.h"
#include "programs/assembly/localiser_options.h"
#include "world/landmark_codes.h"

namespace ninedot {
namespace {

/// What fewer pictures show of the dictionary's may be a code that was misread once.
constexpr std::size_t kPicturesOfOneThatIsThere = 3;
/// Beside so many codes the colours of a small sheet seldom tell whose they are to a percent. For a first look it is
/// enough to know which may be there; among those the second one decides, as strictly as ever. [1]
constexpr double kOddsOfACandidate = 0.3;

[[noreturn]] void refuse(const std::string& what) { throw StartupError(ExitStatus::kWrongUsage, what); }

/// Which places count beside those of the origins.
enum class Believed : std::uint8_t { kMeasured, kAll };

bool has_uncertainty(const MappedLandmark& landmark) { return landmark.covariance.topLeftCorner<3, 3>().trace() > 0; }

std::optional<std::uint16_t> id_of(const std::string& word) {
  std::uint16_t id = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), id);
  return error == std::errc() && end == word.data() + word.size() ? std::optional(id) : std::nullopt;
}

bool can_be_told_apart(std::string_view code, const std::vector<MapLandmarkConfig>& landmarks) {
  return std::ranges::all_of(landmarks, [&](const MapLandmarkConfig& other) {
    return code_distance(other.code, code).places >= kLeastCodeDistance;
  });
}

/// Adds those of the dictionary. One whose id the configuration gives to another code has an id beyond the
/// dictionary's: left out, its sheet would be taken for that of the nearest code. \return  their ids, in order
std::vector<std::uint16_t> add_dictionary(Config& config) {
  std::vector<std::uint16_t> added;
  const std::vector<MapLandmarkConfig> own = config.landmarks;
  const auto is_taken = [&](int id) { return std::ranges::find(own, id, &MapLandmarkConfig::id) != own.end(); };
  int beyond = kKnownCodes + 1;
  for (int known = 1; known <= kKnownCodes && config.landmarks.size() < LandmarkMap::kCapacity; ++known) {
    const std::string_view code = known_code(known).value_or("");
    if (!can_be_told_apart(code, own)) continue;
    while (is_taken(beyond)) ++beyond;
    const int id = is_taken(known) ? beyond++ : known;
    MapLandmarkConfig& landmark = config.landmarks.emplace_back();
    landmark.id = id;
    landmark.code = code;
    added.push_back(static_cast<std::uint16_t>(id));
  }
  std::ranges::sort(added);
  config.pose.solver = "full";  // the only one that serves several
  config.pose.max_ambiguity = std::max(config.pose.max_ambiguity, kOddsOfACandidate);
  return added;
}

[[noreturn]] void refuse_origin(const std::string& origin, const std::string& config_path, const LandmarkMap& map) {
  std::vector<int> ids;
  for (const MappedLandmark& landmark : map.landmarks()) ids.push_back(landmark.id);
  const bool are_many = ids.size() > 10;
  if (are_many) ids.resize(10);
  refuse(fmt::format("--origin {}: {} has no such landmark; it has {}{}", origin, config_path, fmt::join(ids, ", "),
                     are_many ? ", ..." : ""));
}

std::vector<std::uint16_t> named_origins(const std::vector<std::string>& origins, const LandmarkMap& map,
                                         const std::string& config_path) {
  std::vector<std::uint16_t> exact;
  for (const std::string& word : origins) {
    const std::optional<std::uint16_t> id = id_of(word);
    if (!id)
      refuse(fmt::format("--origin {}: give the id of a landmark, or \"measured\" or \"map\", and then nothing else",
                         word));
    const MappedLandmark* const origin = map.find(*id);
    if (origin == nullptr) refuse_origin(word, config_path, map);
    if (std::ranges::count(exact, *id) > 0) refuse(fmt::format("--origin {}: is named twice", word));
    if (!exact.empty() && !origin->has_place)
      refuse(fmt::format("--origin {}: a further origin needs its position_mm in {}", origin->id, config_path));
    exact.push_back(*id);
  }
  return exact;
}

/// Places that do not count are forgotten.
LandmarkMap with_believed(const LandmarkMap& map, const std::vector<std::uint16_t>& exact, Believed believed) {
  std::vector<MappedLandmark> landmarks(map.landmarks().begin(), map.landmarks().end());
  for (MappedLandmark& landmark : landmarks) {
    const bool counts = landmark.has_place && (believed == Believed::kAll || !landmark.from_pictures);
    if (!counts && std::ranges::count(exact, landmark.id) == 0) landmark = {landmark.id, landmark.code, {}, false};
  }
  return LandmarkMap(std::move(landmarks));
}

}  // namespace

bool MapStart::is_exact(std::uint16_t id) const noexcept { return std::ranges::count(exact, id) > 0; }
bool MapStart::is_added(std::uint16_t id) const noexcept { return std::ranges::binary_search(added, id); }

bool MapStart::is_given(std::uint16_t id) const noexcept {
  const MappedLandmark* const landmark = known.find(id);
  return is_exact(id) || (landmark != nullptr && landmark->has_place && has_uncertainty(*landmark));
}

std::uint16_t MapStart::origin() const noexcept {
  if (!exact.empty()) return exact.front();
  const auto given =
      std::ranges::find_if(known.landmarks(), [&](const MappedLandmark& one) { return is_given(one.id); });
  return given == known.landmarks().end() ? std::uint16_t{0} : given->id;
}

SeenLandmarks seen_in(std::span<const RecordedSightings> frames, std::size_t recordings) {
  SeenLandmarks seen{{}, {}, std::vector<std::size_t>(recordings)};
  std::vector<double> speeds_px_s;
  for (const RecordedSightings& frame : frames) {
    speeds_px_s.push_back(frame.fastest_px_s);
    for (const LandmarkSighting& sighting : frame.list) ++seen.pictures[sighting.id];
    if (frame.list.size() < 2) continue;
    ++seen.joining[frame.recording];
    for (const LandmarkSighting& sighting : frame.list) seen.together.insert(sighting.id);
  }
  if (speeds_px_s.empty()) return seen;
  const auto middle = speeds_px_s.begin() + static_cast<std::ptrdiff_t>(speeds_px_s.size() / 2);
  std::ranges::nth_element(speeds_px_s, middle);
  seen.speed_px_s = *middle;
  return seen;
}

MapStart map_start(const Config& config, const std::string& config_path, const std::vector<std::string>& origins,
                   bool with_dictionary) {
  MapStart start{config, {}, {}, {}, config.pose.max_ambiguity};
  if (with_dictionary) start.added = add_dictionary(start.config);
  if (start.config.landmarks.size() < 2)
    refuse(
        fmt::format("{}: a map needs two [[landmarks]] at least, each with its id and code; or --new, which looks "
                    "for those of `ninedot pattern --id`",
                    config_path));
  const LandmarkMap map = landmark_map(start.config);
  const bool takes_all = origins.front() == "map", takes_measured = origins.front() == "measured";
  if (!(takes_all || takes_measured) || origins.size() > 1) {
    start.exact = named_origins(origins, map, config_path);
    start.known = with_believed(map, start.exact, Believed::kMeasured);
    return start;
  }
  start.known = with_believed(map, {}, takes_all ? Believed::kAll : Believed::kMeasured);
  for (const MappedLandmark& landmark : start.known.landmarks())
    if (landmark.has_place && !has_uncertainty(landmark)) start.exact.push_back(landmark.id);
  if (!start.is_given(start.origin()))
    refuse(fmt::format("--origin {}: {} has no landmark with {}: name the landmark that is to be the origin",
                       origins.front(), config_path, takes_all ? "a place" : "a measured place"));
  return start;
}

MapStart second_start(const MapStart& first, const BuiltMap& map, const SeenLandmarks& seen) {
  MapStart second = first;
  second.config.pose.max_ambiguity = first.max_ambiguity;
  const auto is_gone = [&](int id) {
    const auto pictures = seen.pictures.find(static_cast<std::uint16_t>(id));
    return first.is_added(static_cast<std::uint16_t>(id)) && !first.is_exact(static_cast<std::uint16_t>(id)) &&
           (pictures == seen.pictures.end() || pictures->second < kPicturesOfOneThatIsThere);
  };
  std::erase_if(second.added, is_gone);
  std::erase_if(second.config.landmarks, [&](const MapLandmarkConfig& landmark) { return is_gone(landmark.id); });
  std::vector<MappedLandmark> known(first.known.landmarks().begin(), first.known.landmarks().end());
  std::erase_if(known, [&](const MappedLandmark& one) { return is_gone(one.id); });
  second.known = LandmarkMap(std::move(known));
  for (MapLandmarkConfig& landmark : second.config.landmarks) {
    const auto placed = std::ranges::find(map.placed, landmark.id, &MappedLandmark::id);
    if (placed == map.placed.end()) continue;
    const Eigen::Vector3d p_mm = placed->T_world_landmark.translation_m / kMetresPerMm;
    const Eigen::Quaterniond q = placed->T_world_landmark.quaternion();
    landmark.position_mm = {p_mm.x(), p_mm.y(), p_mm.z()};
    landmark.orientation_wxyz = {q.w(), q.x(), q.y(), q.z()};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const auto at = static_cast<Eigen::Index>(axis);
      landmark.sigma_position_mm[axis] = std::sqrt(placed->covariance(at, at)) / kMetresPerMm;
      landmark.sigma_rotation_deg[axis] = std::sqrt(placed->covariance(at + 3, at + 3)) * kDegPerRad;
    }
  }
  return second;
}

std::vector<MappedLandmark> landmarks_of_map(const BuiltMap& map, const MapStart& start) {
  std::vector<MappedLandmark> landmarks;
  for (const MappedLandmark& known : start.known.landmarks()) {
    const auto placed = std::ranges::find(map.placed, known.id, &MappedLandmark::id);
    if (placed == map.placed.end()) {
      if (!start.is_added(known.id)) landmarks.push_back({known.id, known.code, {}, false});
      continue;
    }
    MappedLandmark& landmark = landmarks.emplace_back(*placed);
    const bool is_contradicted = std::ranges::count(map.disagreeing_surveys, known.id) > 0;
    landmark.from_pictures =
        !start.is_exact(known.id) && (known.from_pictures || !start.is_given(known.id) || is_contradicted);
  }
  return landmarks;
}

}  // namespace ninedot
