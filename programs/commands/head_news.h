#pragma once
/// How `ninedot calibrate pan-tilt` fares, for another program.
#include <cstddef>
#include <string>
#include <vector>

#include "base/head_angles.h"
#include "calibrate_head/head_calibration.h"
#include "calibrate_head/head_tour.h"
#include "programs/commands/json_news.h"

namespace ninedot {

struct TourState {
  HeadTour::Part part = HeadTour::Part::kFind;
  std::size_t stops = 0, planned = 0;  ///< made, and in all; 0: not known yet
  HeadAngles told;                     ///< [rad]
  bool is_seen = false;                ///< a landmark, in the newest picture
  bool is_inhibited = false;
};

/// Threads: one caller.
class HeadNews final : public JsonNews {
 public:
  using JsonNews::JsonNews;

  void moving(const TourState& state);
  /// \param lines  as head_summary has them \param out  the file
  void done(const HeadCalibration& head, const std::vector<std::string>& lines, const std::string& out);
};

}  // namespace ninedot
