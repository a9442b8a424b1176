#include "programs/service/map_reloader.h"

#include <fmt/format.h>

#include <memory>
#include <utility>

#include "programs/assembly/input_files.h"
#include "programs/assembly/localiser_options.h"
#include "programs/assembly/make_localiser.h"
#include "world/map_changes.h"

namespace ninedot {
namespace {

/// Lines that one wrong map may cost: the main thread, which feeds the watchdog, waits for whoever reads the log.
constexpr std::size_t kMostProblems = 20;

}  // namespace

MapReloader::MapReloader(const Config& config, const ConfigProblems& keys, std::string config_path,
                         RoomMapHandoff& maps, ServiceLog& log)
    : config_(config), keys_(keys), config_path_(std::move(config_path)), maps_(maps), log_(log) {
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

void MapReloader::request() {
  if (config_.map.empty())
    return log_.write("SIGHUP reads the map again, and there is no map file: name one with 'map' in " + config_path_);
  const std::lock_guard lock(mutex_);
  is_asked_ = true;
  news_.notify_one();
}

void MapReloader::take(const Report& /*newest*/, bool /*is_new*/, MonoTime /*now*/) {
  maps_.free_returned();
  std::vector<std::string> lines;
  {
    const std::lock_guard lock(mutex_);
    lines.swap(lines_);
  }
  for (const std::string& line : lines) log_.write(line);
}

void MapReloader::run(const std::stop_token& stop) {
  for (std::unique_lock lock(mutex_);;) {
    if (!news_.wait(lock, stop, [this] { return is_asked_; })) return;
    is_asked_ = false;
    lock.unlock();
    std::vector<std::string> lines = read_again();
    lock.lock();
    lines_.insert(lines_.end(), lines.begin(), lines.end());
  }
}

/// \return  what is to be said of it
std::vector<std::string> MapReloader::read_again() {
  ConfigProblems problems = keys_;
  Config fresh = config_;
  fresh.landmarks.clear();
  read_map(fresh, problems);
  std::vector<std::string> lines;
  for (const ConfigProblem& problem : problems.list)
    if (lines.size() < kMostProblems) lines.push_back(problem_text(config_path_, problem));
  if (problems.list.size() > kMostProblems)
    lines.push_back(
        fmt::format("{} more: see 'ninedot check --config {}'", problems.list.size() - kMostProblems, config_path_));
  const LandmarkMap before = landmark_map(config_);
  LocaliserOptions options;
  if (lines.empty()) {
    options = localiser_options(fresh);
    if (is_room(options.map) != is_room(before))
      lines.push_back(
          fmt::format("{}: one black-and-white landmark alone is looked for in another way than coded ones or several: "
                      "restart the service to change from one to the other",
                      config_.map));
  }
  if (!lines.empty()) {
    lines.push_back(fmt::format("map kept: nothing of {} is used; correct it and send SIGHUP again", config_.map));
    return lines;
  }
  const MapChanges changes = map_changes(before, options.map);
  const std::size_t count = options.map.landmarks().size();
  maps_.put(std::make_unique<RoomMap>(options.seeker.landmark, std::move(options.map), options.trust.max_ambiguity));
  config_.landmarks = std::move(fresh.landmarks);
  return {
      fmt::format("map {} read again: {} in all, {} added, {} removed, {} moved, {} with another code or uncertainty",
                  config_.map, count, changes.added, changes.removed, changes.moved, changes.described)};
}

}  // namespace ninedot
