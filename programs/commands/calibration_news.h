#pragma once
/// How `ninedot calibrate camera` fares, for another program: a line of JSON for each piece of news.
/// docs/calibrating.md has the table.
#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "calibrate_camera/lens_calibration.h"
#include "programs/commands/gathering_view.h"
#include "programs/commands/json_news.h"

namespace ninedot {

/// Where somebody should hold the sheet.
struct SheetGhost {
  std::vector<std::string> meets;                      ///< names of the wanted views that it gives
  std::vector<std::vector<Eigen::Vector2d>> outlines;  ///< as outlines_of has them [px]
};

/// Threads: one caller.
class CalibrationNews final : public JsonNews {
 public:
  using JsonNews::JsonNews;

  /// \param sheet_px  border of the sheet in the newest picture; empty: it shows none
  void gathering(const GatheringState& state, std::span<const Eigen::Vector2d> sheet_px, const SheetGhost& ghost);
  /// \param out, picture  the files; picture is empty where there is none
  void done(const LensCalibration& result, const std::vector<std::string>& lines, const std::string& out,
            const std::string& picture);
};

}  // namespace ninedot
