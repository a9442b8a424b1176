#pragma once
/// Scores what the product reports on a recording with ground truth.
#include <optional>
#include <string>
#include <vector>

#include "tests/bench/case_folder.h"

namespace ninedot::bench {

/// One landmark of one frame: the truth, and what was reported about it.
struct Shot {
  int frame = 0;
  TruePose truth;
  bool found = false;  ///< reported within 20 % of the distance of the truth
  double position_error_m = 0;
  double rotation_error_rad = 0;
  double normalised_error_squared = 0;  ///< e^T C^-1 e over the six degrees of freedom, C as reported; expected 6
  double bound_m = 0;                   ///< Cramer-Rao bound of the position (all axes together), 0 = unknown
  double process_us = 0;
};

struct CaseScore {
  std::string name;
  std::vector<Shot> shots;  ///< one per landmark and frame
  int frames = 0;
  int false_landmarks = 0;  ///< reported where there is none, or further than 20 % of the distance from the truth
};

/// Runs the frames of a case in their order through a new localiser with default options (tracking included, as
/// `ninedot replay` does) and compares. A frame counts as reported when its report is valid.
CaseScore score_case(const CaseFolder& recording);

/// Median; none without values. Linear interpolation between the two middle ones.
std::optional<double> median(std::vector<double> values);

}  // namespace ninedot::bench
