// `ninedot map`: where landmarks hang, from recordings in which they appear together with their neighbours.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "base/startup_error.h"
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
#include "programs/commands/map_findings.h"
#include "programs/commands/map_news.h"
#include "programs/commands/map_start.h"
#include "programs/commands/named_option.h"
#include "programs/commands/output_check.h"
#include "programs/commands/progress.h"
#include "programs/commands/recording_frames.h"

namespace ninedot {
namespace {

struct MapArguments {
  std::vector<std::string> recordings, origins;
  std::string config, camera, out, plan;
  std::string progress;  // "json", or nothing
  bool with_dictionary = false;
};

/// It is an SVG whatever it is called, and under another name no program would show it, or a folder's only map be gone.
void check_plan(const std::string& plan) {
  std::error_code none;
  if (plan.empty() || plan == "-" || std::filesystem::is_character_file(plan, none)) return;
  if (std::filesystem::path(plan).extension() != ".svg")
    throw StartupError(ExitStatus::kWrongUsage, fmt::format("--plan {}: end the file's name with .svg", plan));
}

/// Before the work. The map that the configuration names may be made again in its place.
void check_map_files(const MapArguments& arguments, const Config& config) {
  for (const std::string& recording : arguments.recordings) check_recording(recording);
  refuse_repeated(arguments.recordings);
  std::vector<std::string> inputs = files_of(config, arguments.recordings, arguments.camera);
  check_outputs({{"--plan", arguments.plan}}, inputs);
  std::erase(inputs, config.map);
  inputs.insert(inputs.end(), arguments.recordings.begin(), arguments.recordings.end());
  inputs.push_back(arguments.config);
  check_outputs({{"--out", arguments.out}, {"--plan", arguments.plan}}, inputs);
  check_plan(arguments.plan);
}

/// Where it is told how far the work is: a terminal, and another program, which may be gone.
class Telling {
 public:
  /// \param news  may be null
  explicit Telling(MapNews* news) : news_(news) {}

  void read(const std::string& recording, const MapReading& reading) {
    if (progress_.is_due())
      progress_.show(fmt::format("{}: picture {} of {}", recording, reading.frame, reading.frames));
    if (news_ != nullptr && news_->is_due()) news_->reading(reading);
    check_that_somebody_listens();
  }
  void work(std::string_view what) {
    progress_.show(what);
    if (news_ != nullptr) news_->working(what);
  }
  void clear() { progress_.clear(); }
  void check_that_somebody_listens() const {
    if (news_ != nullptr && news_->is_broken())
      throw StartupError(ExitStatus::kWorkFailed, "nobody reads any more how it fares: it was ended");
  }

 private:
  Progress progress_;
  MapNews* news_;
};

std::vector<RecordedSightings> read_recordings(const MapArguments& arguments, const Config& config, int look,
                                               Telling& telling) {
  std::vector<RecordedSightings> all;
  for (std::size_t i = 0; i < arguments.recordings.size(); ++i) {
    const std::string& recording = arguments.recordings[i];
    const CameraModel camera = recording_camera(recording, arguments.camera, config);
    std::vector<RecordedSightings> frames =
        collect_sightings(recording, i, config, camera, [&](std::size_t frame, std::size_t count) {
          telling.read(recording, {look, i + 1, arguments.recordings.size(), frame, count});
        });
    std::ranges::move(frames, std::back_inserter(all));
  }
  return all;
}

/// A comment for each.
std::vector<std::string> notes_of(const std::vector<MappedLandmark>& landmarks, const BuiltMap& map,
                                  const MapStart& start) {
  std::vector<std::string> notes;
  for (const MappedLandmark& landmark : landmarks) {
    const auto placed = std::ranges::find(map.placed, landmark.id, &MappedLandmark::id);
    if (placed == map.placed.end())
      notes.emplace_back("not placed");
    else if (start.is_exact(landmark.id))
      notes.emplace_back("given");
    else
      notes.push_back(
          fmt::format("{} sightings", map.sighting_counts[static_cast<std::size_t>(placed - map.placed.begin())]));
  }
  return notes;
}

/// The outcome's files, opened before the work, so that a folder that is not there is told at once.
class MapFiles {
 public:
  explicit MapFiles(const MapArguments& arguments) : map_(arguments.out) {
    if (!arguments.plan.empty()) plan_.emplace(arguments.plan);
  }

  void write(const BuiltMap& map, const MapStart& start) {
    const std::vector<MappedLandmark> landmarks = landmarks_of_map(map, start);
    const std::vector<std::string> comment{
        fmt::format("Made by `ninedot map`: uncertainties are 1-sigma, relative to landmark {}.", start.origin()),
        map_summary(map, start)};
    map_.write(format_map(landmarks, comment, notes_of(landmarks, map, start)));
    if (plan_) plan_->write(draw_map_plan(map.placed, start.origin()));
    finish_together({&map_, plan_ ? &*plan_ : nullptr});
  }

 private:
  OutputFile map_;
  std::optional<OutputFile> plan_;
};

void make_map(const MapArguments& arguments, MapNews* news) {
  const Config config = read_config(arguments.config);
  check_map_files(arguments, config);
  MapStart start = map_start(config, arguments.config, arguments.origins, arguments.with_dictionary);
  MapFiles files(arguments);
  Telling telling(news);
  const auto is_of_use = [&](const BuiltMap& map) {
    return map.sightings > 0 &&
           !std::ranges::all_of(map.placed, [&](const MappedLandmark& one) { return start.is_exact(one.id); });
  };
  const auto build = [&](int look, SeenLandmarks& seen) {
    const std::vector<RecordedSightings> frames = read_recordings(arguments, start.config, look, telling);
    seen = seen_in(frames, arguments.recordings.size());
    MapBuilderOptions options;
    options.geometry = localiser_options(start.config).seeker.landmark;
    options.exact = start.exact;
    options.progress = [&telling](std::string_view what) { telling.work(what); };
    BuiltMap map = build_map(frames, start.known, options);
    telling.check_that_somebody_listens();
    return map;
  };
  SeenLandmarks seen;
  BuiltMap map = build(1, seen);
  if (is_of_use(map)) {
    start = second_start(start, map, seen);
    map = build(2, seen);
  }
  telling.clear();
  const std::vector<std::string> lines = map_findings(map, start, seen, arguments.recordings);
  for (const std::string& line : lines) fmt::print(stderr, "ninedot: {}\n", line);
  if (!is_of_use(map)) throw StartupError(ExitStatus::kWorkFailed, why_no_map(seen, start));
  files.write(map, start);
  const std::string wish = map_wish(map);
  fmt::print(stderr, "{}{}{}\n", map_summary(map, start), wish.empty() ? "" : "; ", wish);
  if (news != nullptr) news->done(map, start, lines, arguments.out, arguments.plan);
}

void run_map(const MapArguments& arguments) {
  if (!arguments.progress.empty() && (arguments.out == "-" || arguments.plan == "-"))
    throw StartupError(ExitStatus::kWrongUsage,
                       fmt::format("--progress and {} - would both write to standard output: name a file",
                                   arguments.out == "-" ? "--out" : "--plan"));
  with_news<MapNews>(arguments.progress, [&](MapNews* news) { make_map(arguments, news); });
}

}  // namespace

void add_map_command(CLI::App& app) {
  CLI::App* command =
      app.add_subcommand("map", "Find out where landmarks hang, from recordings that show them together");
  const auto arguments = std::make_shared<MapArguments>();
  command->add_option("RECORDING", arguments->recordings, "folders with frames/, or .y4m files")
      ->required()
      ->check(is_named());
  command->add_option("--config", arguments->config, "which landmarks there are: [[landmarks]] with id and code")
      ->required()
      ->check(is_named());
  command
      ->add_option("--camera", arguments->camera,
                   "calibration; default: camera.yaml of each recording, then that of the configuration")
      ->check(is_named());
  command
      ->add_option(
          "--origin", arguments->origins,
          "what the map hangs on, since pictures tell only how landmarks lie to each other. An id: that landmark keeps "
          "its place of the configuration, or is the world's origin where it has none; may be given again, for others "
          "that have a place. measured: all whose place was surveyed, as exactly as sigma_position_mm says. map: those "
          "and the places that an earlier `ninedot map` found")
      ->allow_extra_args(false)
      ->required();
  command->add_flag("--new", arguments->with_dictionary,
                    "landmarks of `ninedot pattern --id` that the configuration does not have join the map where the "
                    "pictures show them");
  command->add_option("--out", arguments->out, "file for the map, which the configuration's key 'map' may name")
      ->required()
      ->check(is_named());
  command->add_option("--plan", arguments->plan, "FILE.svg: the map from above, with its uncertainties")
      ->check(is_named());
  command
      ->add_option("--progress", arguments->progress,
                   "json: a line of JSON on standard output for each piece of news, for programs that show them")
      ->check(CLI::IsMember({"json"}));
  command->callback([arguments] { run_map(*arguments); });
}

}  // namespace ninedot
