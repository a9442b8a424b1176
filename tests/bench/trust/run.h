#pragma once
/// Draws and judges on several threads.
#include <cstdio>
#include <filesystem>

#include "tests/bench/trust/judge.h"
#include "tests/bench/trust/tally.h"

namespace ninedot::bench {

struct RunOptions {
  unsigned threads = 1;
  CameraKind camera = CameraKind::kGrey;
  std::FILE* csv = nullptr;      ///< a line per picture
  std::filesystem::path save{};  ///< PNG of every picture that is wrong and valid; empty: none
  bool save_all = false;         ///< of every picture
  std::size_t slowest = 0;       ///< instead: of so many that took longest, once all are judged
  bool progress = false;         ///< on standard error
};

/// The tallies do not depend on the number of threads.
Tallies run_jobs(const std::vector<Job>& jobs, const RunOptions& options);

/// Median work of a landmark at 1.5 m that is searched everywhere [ms of processor's time].
double usual_work_ms();

}  // namespace ninedot::bench
