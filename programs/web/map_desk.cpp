#include "programs/web/map_desk.h"

#include <fmt/format.h>

#include <cstddef>
#include <filesystem>
#include <optional>
#include <utility>
#include <vector>

#include "base/json_text.h"
#include "base/startup_error.h"
#include "drivers/posix/text_file.h"
#include "programs/web/map_request.h"

namespace ninedot {
namespace {

constexpr std::string_view kMap = "map.toml", kPlan = "plan.svg";
constexpr std::string_view kUse = "use ";
constexpr std::size_t kMostReport_bytes = std::size_t{256} * 1024;

/// By what the service said of its first picture: its camera.yaml is there all the same, and a guess.
bool is_of_uncalibrated_camera(const std::string& recording) {
  try {
    const std::string report = read_text_file(recording + "/reports/000000.json", kMostReport_bytes);
    return report.find(R"("calibrated":false)") != std::string::npos;
  } catch (const StartupError&) {
    return false;  // nobody knows
  }
}

}  // namespace

MapDeskOptions map_desk_options(const Config& config, const std::string& config_path, bool has_token) {
  MapDeskOptions options;
  options.config_path = config_path, options.has_token = has_token;
  options.map = config.map;
  options.folder = config.web.recordings + "/maps";
  if (config.web.recordings.empty())
    options.why_not =
        "A map is built from recordings, and none are kept: set `recordings` of [web], to \"/var/lib/ninedot-web\" for "
        "instance.";
  else if (!has_token)
    options.why_not = "Without a token no map can be built: set `token_file` of [web].";
  return options;
}

DeskReply MapDesk::reply_to(std::string_view text) {
  if (!options_.why_not.empty()) return {403, options_.why_not + "\n"};
  if (text == "cancel") return with_state(job_.cancel(JobGroup::kMap));
  if (text.starts_with(kUse)) return use(text.substr(kUse.size()));
  return start(text);
}

DeskReply MapDesk::start(std::string_view text) {
  const std::optional<MapRequest> request = parse_map_request(text);
  if (!request) return {400, "Say start, the origin, and which recordings; cancel; or use and which one.\n"};
  std::vector<std::string> recordings;
  for (const std::string_view name : request->recordings) {
    recordings.push_back(options_.folder_of(name));
    if (recordings.back().empty()) return {404, fmt::format("There is no recording {}, or it is not over.\n", name)};
    if (is_of_uncalibrated_camera(recordings.back()))
      return {409,
              fmt::format("{} was made while the camera was not calibrated: calibrate it, and record again.\n", name)};
  }
  return with_state(job_.start(
      {JobGroup::kMap, "map", options_.folder, [&](const std::filesystem::path& folder) {
         std::vector<std::string> words{"map"};
         words.insert(words.end(), recordings.begin(), recordings.end());
         words.insert(words.end(), {"--config", options_.config_path, "--origin", std::string(request->origin), "--out",
                                    (folder / kMap).string(), "--plan", (folder / kPlan).string()});
         if (request->with_new) words.emplace_back("--new");
         return words;
       }}));
}

DeskReply MapDesk::use(std::string_view name) {
  const std::string file = file_of(fmt::format("{}/{}", name, kMap));
  return file.empty() ? DeskReply{400, "There is no such map.\n"}
                      : request_.begin_with_file("map", file, options_.has_token);
}

DeskReply MapDesk::with_state(const DeskReply& reply) const {
  return reply.status == 200 ? DeskReply{200, state_json()} : reply;
}

std::string MapDesk::state_json() const {
  return fmt::format(R"({{"why_not":{},"use":{},"map":{},"config":{},"folder":{},"landmarks":{},{}}})",
                     json_text(options_.why_not), json_text(request_.why_not(options_.has_token)),
                     json_text(options_.map), json_text(options_.config_path), json_text(options_.folder),
                     options_.landmarks(), job_.state_fields(JobGroup::kMap));
}

std::string MapDesk::file_of(std::string_view path) const { return file_of_job(options_.folder, path, {kMap, kPlan}); }

}  // namespace ninedot
