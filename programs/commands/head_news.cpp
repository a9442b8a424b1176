#include "programs/commands/head_news.h"

#include <fmt/format.h>

#include <string_view>

#include "base/json_text.h"
#include "base/units.h"

namespace ninedot {
namespace {

const char* word_of(HeadTour::Part part) {
  switch (part) {
    case HeadTour::Part::kFind:
      return "find";
    case HeadTour::Part::kReach:
      return "reach";
    case HeadTour::Part::kGrid:
      return "stops";
    case HeadTour::Part::kHome:
      break;
  }
  return "home";
}

/// What was travelled, by what it was told and in truth, and how well that is known. [deg]
std::string axis_json(const AxisCalibration& axis) {
  const TablePoint &first = axis.points.front(), &last = axis.points.back();
  return fmt::format(R"({{"told":[{:.3f},{:.3f}],"are":[{:.3f},{:.3f}],"spread":{:.4f},"play":{}}})",
                     first.told_rad * kDegPerRad, last.told_rad * kDegPerRad, first.angle_rad * kDegPerRad,
                     last.angle_rad * kDegPerRad, axis.spread_rad * kDegPerRad,
                     axis.sees_play ? fmt::format("{:.4f}", axis.play_rad * kDegPerRad) : "null");
}

}  // namespace

void HeadNews::moving(const TourState& state) {
  say(fmt::format(
      R"({{"state":"moving","part":"{}","stops":{},"planned":{},"pan_deg":{:.2f},"tilt_deg":{:.2f},"seen":{},"inhibited":{}}})",
      word_of(state.part), state.stops, state.planned, state.told.pan_rad * kDegPerRad,
      state.told.tilt_rad * kDegPerRad, state.is_seen, state.is_inhibited));
}

void HeadNews::done(const HeadCalibration& head, const std::vector<std::string>& lines, const std::string& out) {
  say(fmt::format(
      R"({{"state":"done","stops":{},"left_out":{},"foretold_deg":{:.4f},"before_deg":{:.4f},"pan":{},"tilt":{},"lines":{},"file":{}}})",
      head.stops, head.left_out, head.foretold_rad * kDegPerRad, head.foretold_before_rad * kDegPerRad,
      axis_json(head.pan), axis_json(head.tilt), texts_json(lines), json_text(out)));
}

}  // namespace ninedot
