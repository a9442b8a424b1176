#include "tests/bench/limits.h"

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <numbers>

namespace ninedot::bench {
namespace {

constexpr double kDeg = 180 / std::numbers::pi;

/// What a median over no values prints as.
constexpr const char* kNothing = "nothing found";

using Filter = std::function<bool(const Shot&)>;

std::vector<Shot> filtered(const CaseScore& score, const Filter& filter) {
  std::vector<Shot> shots;
  std::copy_if(score.shots.begin(), score.shots.end(), std::back_inserter(shots), filter);
  return shots;
}

bool everything(const Shot&) { return true; }

std::size_t count_found(const std::vector<Shot>& shots) {
  return static_cast<std::size_t>(
      std::count_if(shots.begin(), shots.end(), [](const Shot& shot) { return shot.found; }));
}

Verdict verdict(bool reached) { return reached ? Verdict::kReached : Verdict::kMissed; }

LimitRow found_row(const CaseScore& score, const std::string& set, const std::string& to_reach, double part,
                   const Filter& filter) {
  const auto shots = filtered(score, filter);
  const std::size_t found = count_found(shots);
  if (shots.empty()) return {set, to_reach, "no such frames", Verdict::kNotMeasured};
  std::string measured = fmt::format("{} of {}", found, shots.size());
  std::string missing;
  for (const Shot& shot : shots) {
    if (!shot.found) missing += fmt::format("{}{}", missing.empty() ? "" : ", ", shot.frame);
  }
  if (!missing.empty() && shots.size() - found <= 8) measured += ", missing: frame " + missing;
  return {set, to_reach, measured, verdict(static_cast<double>(found) >= part * static_cast<double>(shots.size()))};
}

LimitRow bound_row(const CaseScore& score, double limit, const Filter& filter) {
  std::vector<double> ratios;
  for (const Shot& shot : filtered(score, filter)) {
    if (shot.found && shot.bound_m > 0) ratios.push_back(shot.position_error_m / shot.bound_m);
  }
  const auto value = median(ratios);
  return {score.name, fmt::format("median position error <= {} x its bound", limit),
          value ? fmt::format("{:.2f} x ({} frames)", *value, ratios.size()) : kNothing,
          verdict(value && *value <= limit)};
}

LimitRow relative_row(const CaseScore& score, double limit_percent) {
  std::vector<double> errors_percent;
  for (const Shot& shot : score.shots) {
    if (shot.found) errors_percent.push_back(100 * shot.position_error_m / shot.truth.distance_m());
  }
  const auto value = median(errors_percent);
  return {score.name, fmt::format("median position error <= {} % of the distance", limit_percent),
          value ? fmt::format("{:.3f} %", *value) : kNothing, verdict(value && *value <= limit_percent)};
}

void add_case_rows(const CaseScore& score, std::vector<LimitRow>& rows) {
  const std::string& name = score.name;
  if (name == "positions" || name == "offcentre") {
    rows.push_back(found_row(score, name, "every frame found", 1, everything));
    rows.push_back(bound_row(score, 1.5, everything));
    rows.push_back(relative_row(score, 0.15));
  } else if (name == "motion") {
    rows.push_back(found_row(score, name, "every frame found", 1, everything));
    rows.push_back(relative_row(score, 0.3));
  } else if (name == "range") {
    // The stated ends are meant inclusively, and a pose is known to a tenth of a millimetre.
    const auto in_range = [](const Shot& shot) {
      return shot.truth.distance_m() > 0.295 && shot.truth.distance_m() < 7.05;
    };
    rows.push_back(found_row(score, name, "found from 0.3 to 7 m", 1, in_range));
  } else if (name == "tilt") {
    const auto in_range = [](const Shot& shot) { return shot.truth.tilt_rad() * kDeg < 75.5; };
    rows.push_back(found_row(score, name, "found up to 75 degrees", 1, in_range));
    rows.push_back(bound_row(score, 2, in_range));
  } else if (name == "occlusion") {
    rows.push_back(found_row(score, name, ">= 95 % found up to 40 % hidden", 0.95,
                             [](const Shot& shot) { return shot.truth.hidden_fraction < 0.405; }));
    rows.push_back(found_row(score, name, ">= 80 % found at 50 % hidden", 0.80, [](const Shot& shot) {
      return shot.truth.hidden_fraction > 0.475 && shot.truth.hidden_fraction < 0.505;
    }));
    rows.push_back(relative_row(score, 0.5));
  } else if (name == "plastic" || name == "lowlight") {
    rows.push_back(found_row(score, name, ">= 95 % found", 0.95, everything));
  } else if (name == "negative") {
    rows.push_back({name, "no false landmark", fmt::format("{} in {} frames", score.false_landmarks, score.frames),
                    verdict(score.false_landmarks == 0)});
  } else if (name == "distorted") {
    rows.push_back(found_row(score, name, "every frame found", 1, everything));
    rows.push_back(bound_row(score, 2, everything));
  }
}

void add_covariance_row(const std::vector<CaseScore>& scores, std::vector<LimitRow>& rows) {
  double sum = 0;
  int count = 0;
  for (const CaseScore& score : scores) {
    if (score.name != "positions" && score.name != "offcentre") continue;
    for (const Shot& shot : score.shots) {
      if (shot.found) sum += shot.normalised_error_squared, ++count;
    }
  }
  if (count == 0) return;
  const double mean = sum / count;
  rows.push_back({"positions + offcentre", "mean normalised error squared (6 degrees of freedom) 4 to 9",
                  fmt::format("{:.2f} ({} frames)", mean, count), verdict(mean >= 4 && mean <= 9)});
}

}  // namespace

std::vector<LimitRow> check_limits(const std::vector<CaseScore>& scores) {
  std::vector<LimitRow> rows;
  for (const CaseScore& score : scores) add_case_rows(score, rows);
  add_covariance_row(scores, rows);
  return rows;
}

std::string markdown_row(const LimitRow& row) {
  const char* const ok = row.verdict == Verdict::kReached ? "yes" : row.verdict == Verdict::kMissed ? "**no**" : "-";
  return fmt::format("| {} | {} | {} | {} |\n", row.set, row.to_reach, row.measured, ok);
}

}  // namespace ninedot::bench
