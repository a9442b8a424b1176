/// bench_cases FOLDER [--rows FILE]: accuracy on recordings with ground truth, one line per recording (and per frame
/// with
/// --frames); appends the rows of the table of limits to FILE. Exit status: 0 measured, 2 could not measure.
#include <fmt/format.h>

#include <unistd.h>
#include <algorithm>
#include <cstdio>
#include <fstream>
#include <numbers>
#include <string_view>

#include "base/startup_error.h"
#include "tests/bench/limits.h"

namespace {

using namespace ninedot;
using namespace ninedot::bench;

constexpr double kDeg = 180 / std::numbers::pi;

std::string text(const std::optional<double>& value, int digits) {
  return value ? fmt::format("{:.{}f}", *value, digits) : "-";
}

void print_frames(const CaseScore& score) {
  fmt::print(
      "\n{}: frame, distance mm, tilt deg, hidden %, found, error mm, bound mm, ratio, rotation deg, e^T C^-1 e, us\n",
      score.name);
  for (const Shot& shot : score.shots) {
    fmt::print("{:6} {:8.0f} {:5.1f} {:5.1f} {} {:9.3f} {:8.3f} {:6.2f} {:7.3f} {:8.2f} {:8.0f}\n", shot.frame,
               shot.truth.distance_m() * 1000, shot.truth.tilt_rad() * kDeg, shot.truth.hidden_fraction * 100,
               shot.found ? "found" : "  -  ", shot.position_error_m * 1000, shot.bound_m * 1000,
               shot.bound_m > 0 ? shot.position_error_m / shot.bound_m : 0, shot.rotation_error_rad * kDeg,
               shot.normalised_error_squared, shot.process_us);
  }
}

void print_summary(const CaseScore& score) {
  std::vector<double> errors_mm, relative_percent, ratios, rotations_deg, normalised, times_us;
  for (const Shot& shot : score.shots) {
    times_us.push_back(shot.process_us);
    if (!shot.found) continue;
    errors_mm.push_back(shot.position_error_m * 1000);
    relative_percent.push_back(100 * shot.position_error_m / shot.truth.distance_m());
    rotations_deg.push_back(shot.rotation_error_rad * kDeg);
    normalised.push_back(shot.normalised_error_squared);
    if (shot.bound_m > 0) ratios.push_back(shot.position_error_m / shot.bound_m);
  }
  const auto largest = [](const std::vector<double>& v) {
    return v.empty() ? std::optional<double>() : *std::max_element(v.begin(), v.end());
  };
  fmt::print("| {} | {}/{} | {} | {} | {} | {} | {} | {} | {} | {} |\n", score.name, errors_mm.size(),
             score.shots.size(), score.false_landmarks, text(median(errors_mm), 2), text(median(relative_percent), 3),
             text(largest(relative_percent), 3), text(median(ratios), 2), text(median(rotations_deg), 3),
             text(median(normalised), 1), text(median(times_us), 0));
}

int measure(const std::string& folder, const char* rows_path, bool per_frame) {
  std::vector<CaseScore> scores;
  for (const std::string& path : find_cases(folder)) {
    if (isatty(fileno(stderr)) != 0) fmt::print(stderr, "\r\x1b[K{}", path);
    scores.push_back(score_case(read_case(path)));
  }
  if (isatty(fileno(stderr)) != 0) fmt::print(stderr, "\r\x1b[K");
  fmt::print(
      "| recording | found | false | median mm | median % | largest % | x bound | median deg | median e^T C^-1 e | "
      "median us |\n");
  fmt::print("|---|---|---|---|---|---|---|---|---|---|\n");
  for (const CaseScore& score : scores) print_summary(score);
  if (per_frame) {
    for (const CaseScore& score : scores) print_frames(score);
  }
  if (rows_path != nullptr) {
    std::ofstream rows(rows_path, std::ios::app);
    for (const LimitRow& row : check_limits(scores)) rows << markdown_row(row);
    if (!rows.flush()) throw StartupError(ExitStatus::kWorkFailed, fmt::format("{}: can't be written", rows_path));
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  const char* rows_path = nullptr;
  std::string folder;
  bool per_frame = false;
  for (int i = 1; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument == "--rows" && i + 1 < argc) {
      rows_path = argv[++i];
    } else if (argument == "--frames") {
      per_frame = true;
    } else {
      folder = argument;
    }
  }
  if (folder.empty()) {
    fmt::print(stderr, "usage: bench_cases FOLDER [--frames] [--rows FILE]\n");
    return 2;
  }
  try {
    return measure(folder, rows_path, per_frame);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_cases: {}\n", error.what());
    return 2;
  }
}
