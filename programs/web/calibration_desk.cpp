#include "programs/web/calibration_desk.h"

#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <utility>

#include "base/json_text.h"
#include "programs/web/jogger.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kCalibration = "camera.yaml", kPicture = "camera.svg", kHeadFile = "head.toml";
constexpr std::string_view kUse = "use ";

std::string limits_of(const HeadAxisConfig& axis) {
  return fmt::format(R"({{"min":{},"max":{}}})", axis.min_deg, axis.max_deg);
}

}  // namespace

CalibrationDeskOptions calibration_desk_options(const Config& config, const std::string& config_path, bool has_token) {
  CalibrationDeskOptions options;
  options.config_path = config_path, options.has_token = has_token;
  options.calibration = config.camera.calibration;
  options.folder = config.web.recordings + "/calibrations";
  options.no_head = why_no_head(config, has_token);
  options.limits =
      fmt::format(R"({{"pan":{},"tilt":{}}})", limits_of(config.pan_tilt.pan), limits_of(config.pan_tilt.tilt));
  if (config.web.recordings.empty())
    options.why_not =
        "There is no place for a calibration: set `recordings` of [web], to \"/var/lib/ninedot-web\" for instance.";
  else if (!has_token)
    options.why_not = "Without a token nothing can be calibrated: set `token_file` of [web].";
  return options;
}

DeskReply CalibrationDesk::reply_to(std::string_view text) {
  if (!options_.why_not.empty()) return {403, options_.why_not + "\n"};
  if (text == "start camera") return start(false);
  if (text == "start pan-tilt") return options_.no_head.empty() ? start(true) : DeskReply{403, options_.no_head + "\n"};
  if (text == "finish") return with_state(job_.finish(JobGroup::kCalibration));
  if (text == "cancel") return with_state(job_.cancel(JobGroup::kCalibration));
  if (text.starts_with(kUse)) return use(text.substr(kUse.size()));
  return {400, "Say start camera, start pan-tilt, finish, cancel, or use and which one.\n"};
}

DeskReply CalibrationDesk::start(bool of_head) {
  const std::string_view of = of_head ? "pan-tilt" : "camera";
  return with_state(job_.start({JobGroup::kCalibration, of, options_.folder, [&](const fs::path& folder) {
                                  return std::vector<std::string>{
                                      "calibrate",
                                      std::string(of),
                                      "--tap",
                                      "--config",
                                      options_.config_path,
                                      "--out",
                                      (folder / (of_head ? kHeadFile : kCalibration)).string()};
                                }}));
}

DeskReply CalibrationDesk::with_state(const DeskReply& reply) const {
  return reply.status == 200 ? DeskReply{200, state_json()} : reply;
}

DeskReply CalibrationDesk::use(std::string_view name) {
  std::error_code none;
  const bool of_head = fs::exists(file_of(fmt::format("{}/{}", name, kHeadFile)), none);
  const std::string file = file_of(fmt::format("{}/{}", name, of_head ? kHeadFile : kCalibration));
  if (file.empty()) return {400, "There is no such calibration.\n"};
  return request_.begin_with_file(of_head ? "head" : "calibration", file, options_.has_token);
}

std::string CalibrationDesk::state_json() const {
  return fmt::format(
      R"({{"why_not":{},"use":{},"calibration":{},"config":{},"folder":{},"head":{{"why_not":{},"limits":{}}},{}}})",
      json_text(options_.why_not), json_text(request_.why_not(options_.has_token)), json_text(options_.calibration),
      json_text(options_.config_path), json_text(options_.folder), json_text(options_.no_head), options_.limits,
      job_.state_fields(JobGroup::kCalibration));
}

std::string CalibrationDesk::file_of(std::string_view path) const {
  return file_of_job(options_.folder, path, {kCalibration, kPicture, kHeadFile});
}

}  // namespace ninedot
