// `ninedot map`: where landmarks hang, from recordings in which they appear together with their neighbours.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/startup_error.h"
#include "base/units.h"
#include "config/map_file.h"
#include "drawing/map_plan.h"
#include "drivers/posix/output_file.h"
#include "drivers/recording/recording_index.h"
#include "mapping/map_builder.h"
#include "programs/assembly/input_files.h"
#include "programs/assembly/localiser_options.h"
#include "programs/assembly/recording_camera.h"
#include "programs/commands/collect_sightings.h"
#include "programs/commands/commands.h"
#include "programs/commands/progress.h"

namespace ninedot {
namespace {

struct MapArguments {
  std::vector<std::string> recordings;
  std::string config, camera, out, plan;
  std::vector<std::uint16_t> origins;
};

/// More than these few pictures of one landmark are counted, not named.
constexpr std::size_t kNamedFrames = 5;

[[noreturn]] void refuse(const std::string& what) { throw StartupError(ExitStatus::kWrongUsage, what); }

void check_landmarks(const MapArguments& arguments, const Config& config, const LandmarkMap& known) {
  if (config.landmarks.size() < 2)
    refuse(fmt::format("{}: a map needs two [[landmarks]] at least, each with its id and code", arguments.config));
  for (std::size_t i = 0; i < arguments.origins.size(); ++i) {
    const MappedLandmark* const origin = known.find(arguments.origins[i]);
    if (origin == nullptr) {
      std::vector<int> ids;
      for (const MappedLandmark& landmark : known.landmarks()) ids.push_back(landmark.id);
      const bool are_many = ids.size() > 10;
      if (are_many) ids.resize(10);
      refuse(fmt::format("--origin {}: {} has no such landmark; it has {}{}", arguments.origins[i], arguments.config,
                         fmt::join(ids, ", "), are_many ? ", ..." : ""));
    }
    if (i > 0 && !origin->has_place)
      refuse(fmt::format("--origin {}: a further origin needs its position_mm in {}", origin->id, arguments.config));
  }
}

/// A recording that is not there or empty was named by mistake.
void check_recording(const std::string& recording) {
  try {
    static_cast<void>(read_recording_index(recording));
  } catch (const StartupError& error) {
    refuse(error.what());
  }
}

std::vector<RecordedSightings> read_recordings(const MapArguments& arguments, const Config& config,
                                               Progress& progress) {
  std::vector<RecordedSightings> all;
  for (std::size_t i = 0; i < arguments.recordings.size(); ++i) {
    const std::string& recording = arguments.recordings[i];
    check_recording(recording);
    const CameraModel camera = recording_camera(recording, arguments.camera, config);
    std::vector<RecordedSightings> frames =
        collect_sightings(recording, i, config, camera, [&](std::size_t frame, std::size_t count) {
          if (progress.is_due()) progress.show(fmt::format("{}: picture {} of {}", recording, frame, count));
        });
    std::ranges::move(frames, std::back_inserter(all));
  }
  return all;
}

/// The configuration with the places of a first map: with them the localiser foretells where landmarks are, and finds
/// those that are too small to be found unexpected.
Config with_places(Config config, const BuiltMap& map) {
  for (MapLandmarkConfig& landmark : config.landmarks) {
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
  return config;
}

std::string list_of(const std::vector<std::uint16_t>& ids) { return fmt::format("{}", fmt::join(ids, ", ")); }

/// What a person should know beside the map.
void tell_findings(const BuiltMap& map, const MapArguments& arguments) {
  std::map<std::pair<std::uint16_t, std::size_t>, std::vector<std::uint64_t>> disagreeing;
  for (const DisagreeingSighting& sighting : map.disagreeing)
    disagreeing[{sighting.id, sighting.recording}].push_back(sighting.frame);
  for (const auto& [where, frames] : disagreeing) {
    const std::vector<std::uint64_t> named(
        frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(std::min(frames.size(), kNamedFrames)));
    fmt::print(stderr, "ninedot: landmark {} disagrees with the rest in {} {} of {} ({}{}) and was left out there\n",
               where.first, frames.size(), frames.size() == 1 ? "picture" : "pictures",
               arguments.recordings[where.second], fmt::join(named, ", "), named.size() < frames.size() ? ", ..." : "");
  }
  for (const std::uint16_t id : map.disagreeing_surveys)
    fmt::print(stderr, "ninedot: landmark {}: the pictures contradict its surveyed place, which was not used\n", id);
  for (const std::uint16_t id : map.unseen)
    fmt::print(stderr, "ninedot: landmark {} is not placed: no picture shows it beside another one\n", id);
  for (const std::vector<std::uint16_t>& island : map.islands)
    fmt::print(stderr,
               "ninedot: not placed: {}: take two pictures at least that show one of them beside one that is placed\n",
               list_of(island));
  if (map.variance_factor > 1.5)
    fmt::print(
        stderr,
        "ninedot: the sightings spread {:.1f} times as widely as they say, and sigmas were enlarged by that: is it "
        "the right calibration, and were the sheets flat and still?\n",
        std::sqrt(map.variance_factor));
}

std::vector<std::string> notes_of(const BuiltMap& map, const MapArguments& arguments) {
  std::vector<std::string> notes;
  for (std::size_t i = 0; i < map.placed.size(); ++i)
    notes.push_back(std::ranges::count(arguments.origins, map.placed[i].id) > 0
                        ? "given"
                        : fmt::format("{} sightings", map.sighting_counts[i]));
  return notes;
}

void run_map(const MapArguments& arguments) {
  const Config config = read_config(arguments.config);
  const LandmarkMap known = landmark_map(config);
  check_landmarks(arguments, config, known);
  // Before the work, so that a folder that is not there is told at once.
  OutputFile map_file(arguments.out);
  std::optional<OutputFile> plan_file;
  if (!arguments.plan.empty()) plan_file.emplace(arguments.plan);
  Progress progress;
  MapBuilderOptions options;
  options.geometry = localiser_options(config).seeker.landmark;
  options.exact = arguments.origins;
  options.threads = static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
  options.progress = [&progress](std::string_view what) { progress.show(what); };
  BuiltMap map = build_map(read_recordings(arguments, config, progress), known, options);
  if (map.placed.size() > arguments.origins.size())
    map = build_map(read_recordings(arguments, with_places(config, map), progress), known, options);
  progress.clear();
  tell_findings(map, arguments);
  if (map.placed.size() <= arguments.origins.size())
    throw StartupError(ExitStatus::kWorkFailed,
                       fmt::format("no landmark could be placed: no two pictures show landmark {} beside another one",
                                   arguments.origins.front()));

  std::string summary = fmt::format("{} of {} landmarks placed, from {} sightings in {} pictures", map.placed.size(),
                                    known.landmarks().size(), map.sightings, map.frames);
  const std::vector<std::string> comment{
      fmt::format("Made by `ninedot map`: uncertainties are 1-sigma, relative to landmark {}.",
                  arguments.origins.front()),
      summary};
  map_file.write(format_map(map.placed, comment, notes_of(map, arguments)));
  map_file.finish();
  if (plan_file) {
    plan_file->write(draw_map_plan(map.placed, arguments.origins.front()));
    plan_file->finish();
  }
  if (map.weakest)
    summary += fmt::format("; a picture that shows {} and {} together would help most: they are certain to {:.2g} mm",
                           map.weakest->a, map.weakest->b, map.weakest->sigma_m / kMetresPerMm);
  fmt::print(stderr, "{}\n", summary);
}

}  // namespace

void add_map_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("map", "Find out where landmarks hang, from recordings that show them together");
  const auto arguments = std::make_shared<MapArguments>();
  command->add_option("RECORDING", arguments->recordings, "folders with frames/, or .y4m files")->required();
  command->add_option("--config", arguments->config, "which landmarks there are: [[landmarks]] with id and code")
      ->required();
  command->add_option("--camera", arguments->camera,
                      "calibration; default: camera.yaml of each recording, then that of the configuration");
  command
      ->add_option(
          "--origin", arguments->origins,
          "landmark whose place is given: that of the configuration, or 0, 0, 0; may be given again for others")
      ->allow_extra_args(false)
      ->required();
  command->add_option("--out", arguments->out, "file for the map, which the configuration's key 'map' may name")
      ->required();
  command->add_option("--plan", arguments->plan, "SVG file: the map from above, with its uncertainties");
  command->callback([arguments] { run_map(*arguments); });
}

}  // namespace ninedot
