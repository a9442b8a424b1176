#include "tests/bench/trust/tally.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace ninedot::bench {
namespace {

std::string or_dash(bool known, const std::string& text) { return known ? text : "-"; }

std::string row_of(const Kind& kind, const Tally& tally, double usual_ms) {
  const double sigma = tally.error_over_sigma(), bound = tally.median_over_bound();
  const std::string wrong =
      is_over_limit(kind, tally) ? fmt::format("**{}**", tally.wrong) : fmt::format("{}", tally.wrong);
  return fmt::format("| {} | {} | {} | {} | {} | {} | {} | {} | {} | {:.1f} |\n", kind.name, tally.pictures,
                     tally.shown, tally.found, tally.valid, wrong,
                     or_dash(tally.shown > 0, fmt::format("{}", tally.beyond)),
                     or_dash(sigma > 0, fmt::format("{:.2f}", sigma)), or_dash(bound > 0, fmt::format("{:.2f}", bound)),
                     tally.slowest_ms / usual_ms);
}

std::string table_of(const std::string& group, const std::vector<Kind>& kinds, const Tallies& tallies,
                     double usual_ms) {
  std::string rows;
  Tally all;
  for (const Kind& kind : kinds) {
    const auto tally = tallies.find(kind.name);
    if (kind.group != group || tally == tallies.end() || tally->second.pictures == 0) continue;
    rows += row_of(kind, tally->second, usual_ms);
    all.add(tally->second);
  }
  if (rows.empty()) return "";
  return fmt::format(
      "\n## {}\n\n| kind | pictures | with landmark | found | valid | wrong and valid | beyond 6 sigma | error / sigma "
      "| "
      "error / bound | slowest |\n|---|---|---|---|---|---|---|---|---|---|\n{}{}",
      group, rows, row_of({"", "**all**"}, all, usual_ms));
}

std::string limits_table(const std::vector<Kind>& kinds, const Tallies& tallies) {
  std::string text = "\n## Limits\n\n| group | wrong and valid, at most | kinds above it |\n|---|---|---|\n";
  for (const Limit& limit : trust_limits()) {
    int rows = 0, above = 0;
    for (const Kind& kind : kinds) {
      const auto tally = tallies.find(kind.name);
      if (kind.group != limit.group || tally == tallies.end()) continue;
      ++rows, above += is_over_limit(kind, tally->second) ? 1 : 0;
    }
    const std::string most =
        limit.wrong_share > 0 ? fmt::format("{:g} % of a kind's pictures", 100 * limit.wrong_share) : "none";
    text +=
        fmt::format("| {} | {} | {} |\n", limit.group, most, or_dash(rows > 0, fmt::format("{} of {}", above, rows)));
  }
  return text;
}

constexpr const char* kExplanation = R"(# Is what it is sure of true?

Written by `{}`; nothing on this page is edited by hand. It exits with 1 while a limit is passed.

Every row is one kind of picture, 640 x 480, through `Localiser` with its defaults. It has seen nothing before; a *track* is ten
frames of a slow motion in a row. *In a room* is through `RoomLocaliser` with a map of one black-and-white sheet, each picture
three times in a row, as long as it takes to be sure. Photographs are windows of those in the Debian packages of the set `trust` in
`toolchains/packages.txt`; `--half tune` and `--half held` are their halves, one to tune by and one to check with. Near misses are
drawn by a small painter, views and camera effects by the tests' renderer, whose truth is exact; a warped sheet is where the plane
lies that fits its nine dots best.

- *found*: something like a landmark, of which three dots at least are in sight, whatever came of it. *valid*: a pose that is not called ambiguous, which is all that a client
  sees who looks at `valid` alone.
- *wrong and valid*: no landmark is in the picture, or the pose is off by more than six sigma and by more than 1 % of the
  distance (position) or 0.01 rad (rotation): the mirror image, a wrong numbering, something else that was taken for the landmark.
- *beyond 6 sigma*: valid, and position or rotation is off by more than six of the sigma that was claimed, however little that is.
- *error / sigma*: root mean square over the valid poses that are not wrong, e^T C^-1 e over six degrees of freedom, divided
  by six: 1 is honest, more is overconfident.
- *error / bound*: median of the position's error over the Cramer-Rao bound of its own frame, where that is known: in the
  first frame of every fourth view.
- *slowest*: the processor's time of the slowest picture, in medians of the usual frame (landmark at 1.5 m, searched everywhere).
  Differs from run to run.

A bold number is over its limit.
)";

}  // namespace

void Tally::add(const Verdict& verdict) {
  ++pictures;
  shown += verdict.shown ? 1 : 0, found += verdict.found ? 1 : 0, valid += verdict.valid ? 1 : 0;
  wrong += verdict.wrong ? 1 : 0, beyond += verdict.beyond ? 1 : 0;
  nees += verdict.nees;
  if (verdict.error_over_bound > 0) over_bound.push_back(verdict.error_over_bound);
  slowest_ms = std::max(slowest_ms, verdict.work_ms);
}

void Tally::add(const Tally& other) {
  pictures += other.pictures, shown += other.shown, found += other.found, valid += other.valid;
  wrong += other.wrong, beyond += other.beyond, nees += other.nees;
  over_bound.insert(over_bound.end(), other.over_bound.begin(), other.over_bound.end());
  slowest_ms = std::max(slowest_ms, other.slowest_ms);
}

double Tally::error_over_sigma() const {
  const int right = valid - wrong;
  return shown > 0 && right > 0 ? std::sqrt(nees / 6 / right) : 0;
}

double Tally::median_over_bound() const {
  if (over_bound.empty()) return 0;
  std::vector<double> sorted = over_bound;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

const std::vector<Limit>& trust_limits() {
  // Where there is no landmark, none may be claimed. Elsewhere 1 %: the mirror image that noise hides is told by odds.
  static const std::vector<Limit> limits{
      {"Photographs", 0}, {"Near misses", 0}, {"Views", 0.01}, {"Camera effects", 0.01}};
  return limits;
}

bool is_over_limit(const Kind& kind, const Tally& tally) {
  for (const Limit& limit : trust_limits())
    if (limit.group == kind.group) return tally.wrong > limit.wrong_share * tally.pictures;
  return false;
}

std::string trust_page(const std::vector<Kind>& kinds, const Tallies& tallies, const TrustRun& run) {
  std::string page = fmt::format(fmt::runtime(kExplanation), run.command);
  page += limits_table(kinds, tallies);
  for (const Limit& limit : trust_limits()) page += table_of(limit.group, kinds, tallies, run.usual_ms);
  return page;
}

}  // namespace ninedot::bench
