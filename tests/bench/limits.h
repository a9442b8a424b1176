#pragma once
/// The accuracy that this project holds itself to, per kind of recording, and whether a measurement reaches it.
#include <string>
#include <vector>

#include "tests/bench/scoring.h"

namespace ninedot::bench {

enum class Verdict { kReached, kMissed, kNotMeasured };

struct LimitRow {
  std::string set;
  std::string to_reach;
  std::string measured;
  Verdict verdict = Verdict::kNotMeasured;
};

/// The rows for recordings named positions, offcentre, motion, range, tilt, occlusion, plastic, lowlight, negative and
/// distorted; recordings of other names have no limits. The covariance row is over positions and offcentre together.
std::vector<LimitRow> check_limits(const std::vector<CaseScore>& scores);

/// "| set | to reach | measured | ok? |" with its closing newline.
std::string markdown_row(const LimitRow& row);

}  // namespace ninedot::bench
