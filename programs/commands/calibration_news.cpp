#include "programs/commands/calibration_news.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <span>

#include "base/json_text.h"
#include "programs/commands/calibration_output.h"

namespace ninedot {
namespace {

std::string polygon_json(std::span<const Eigen::Vector2d> points_px) {
  std::string json;
  for (const Eigen::Vector2d& point : points_px) {
    if (!point.allFinite()) return "[]";
    json += fmt::format("{}[{:.1f},{:.1f}]", json.empty() ? "" : ",", point.x(), point.y());
  }
  return fmt::format("[{}]", json);
}

std::string ghost_json(const SheetGhost& ghost) {
  if (ghost.outlines.empty()) return "null";
  std::string outlines;
  for (const auto& outline : ghost.outlines) outlines.append(outlines.empty() ? "" : ",").append(polygon_json(outline));
  return fmt::format(R"({{"meets":{},"outlines":[{}]}})", texts_json(ghost.meets), outlines);
}

const char* word_of(Looked looked) {
  switch (looked) {
    case Looked::kNoSheet:
      return "none";
    case Looked::kMoving:
      return "moving";
    case Looked::kSeenBefore:
      return "seen";
    case Looked::kBlurred:
      return "blurred";
    case Looked::kTaken:
      break;
  }
  return "taken";
}

std::string number_json(double value) { return std::isfinite(value) ? fmt::format("{:.4g}", value) : "null"; }

}  // namespace

void CalibrationNews::gathering(const GatheringState& state, std::span<const Eigen::Vector2d> sheet_px,
                                const SheetGhost& ghost) {
  say(fmt::format(
      R"({{"state":"gathering","views":{},"wanted":{},"lacks":{},"parts":[{}],"tilts":[{}],"near":{},"looked":"{}","part":{},"sheet":{},"ghost":{}}})",
      state.tally.views, texts_json(state.wanted), texts_json(state.lens_lacks), fmt::join(state.tally.parts, ","),
      fmt::join(state.tally.tilts, ","), state.tally.near, word_of(state.looked),
      state.part ? std::to_string(*state.part) : "null", polygon_json(sheet_px), ghost_json(ghost)));
}

void CalibrationNews::done(const LensCalibration& result, const std::vector<std::string>& lines, const std::string& out,
                           const std::string& picture) {
  const CameraModel& camera = result.fit.camera;
  say(fmt::format(
      R"({{"state":"done","model":"{}","focal_px":[{:.3f},{:.3f}],"centre_px":[{:.3f},{:.3f}],"views":{},"outlines_px":{},"directions_px":{},"directions_worst_px":{},"lines":{},"wish":{},"file":{},"picture":{}}})",
      name_of(camera.model), camera.fx_px, camera.fy_px, camera.cx_px, camera.cy_px, result.views.size(),
      number_json(result.rms_px), number_json(result.directions.median_px()), number_json(result.directions.max_px()),
      texts_json(lines), json_text(wish_for_views(result)), json_text(out), json_text(picture)));
}

}  // namespace ninedot
