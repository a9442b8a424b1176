#include "tests/bench/trust/csv.h"

#include <fmt/format.h>

#include <cstdio>
#include <fstream>
#include <numbers>

namespace ninedot::bench {

namespace {
constexpr double kDegrees = 180 / std::numbers::pi;  // in one radian
}

std::string csv_line(const Strip& strip, std::size_t frame, const Verdict& v) {
  return fmt::format("\"{}\",\"{}\",{},{:d},{:d},{:d},{:d},{:d},{:.4g},{:.4g},{:.4g},{:.4g},{:.3f}\n", strip.kind,
                     strip.name, frame, v.shown, v.found, v.valid, v.wrong, v.beyond, v.nees, 1e3 * v.error_m,
                     v.turn_rad * kDegrees, v.error_over_bound, v.work_ms);
}

bool add_csv(const std::filesystem::path& file, Tallies& tallies) {
  std::ifstream stream(file);
  std::string line;
  if (!std::getline(stream, line) || line + "\n" != kCsvHeader) return false;
  while (std::getline(stream, line)) {
    const std::size_t kind_end = line.find("\",\""), name_end = line.rfind("\",");
    if (line.empty() || line[0] != '"' || kind_end == std::string::npos || name_end <= kind_end) return false;
    int frame = 0, shown = 0, found = 0, valid = 0, wrong = 0, beyond = 0;
    Verdict v;
    double error_mm = 0, turn_deg = 0;
    if (std::sscanf(line.c_str() + name_end + 2, "%d,%d,%d,%d,%d,%d,%lf,%lf,%lf,%lf,%lf", &frame, &shown, &found,
                    &valid, &wrong, &beyond, &v.nees, &error_mm, &turn_deg, &v.error_over_bound, &v.work_ms) != 11)
      return false;
    v.shown = shown != 0, v.found = found != 0, v.valid = valid != 0, v.wrong = wrong != 0, v.beyond = beyond != 0;
    v.error_m = error_mm / 1e3, v.turn_rad = turn_deg / kDegrees;
    tallies[line.substr(1, kind_end - 1)].add(v);
  }
  return true;
}

}  // namespace ninedot::bench
