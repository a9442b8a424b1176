#pragma once
/// Sums of verdicts, one per row of the table, and the limits that they must keep.
#include <map>
#include <string>
#include <vector>

#include "tests/bench/trust/judge.h"

namespace ninedot::bench {

struct Tally {
  int pictures = 0;
  int shown = 0;  ///< of these, pictures with a landmark
  int found = 0;  ///< and so on: the fields of Verdict
  int valid = 0;
  int wrong = 0;
  int beyond = 0;
  double nees = 0;                 ///< sum over valid ones that are not wrong and show a landmark
  std::vector<double> over_bound;  ///< error / bound where it is known
  double slowest_ms = 0;

  void add(const Verdict& verdict);
  void add(const Tally& other);
  /// Root of the mean of e^T C^-1 e / 6: 1 is honest, more is overconfident. 0: there is none.
  double error_over_sigma() const;
  double median_over_bound() const;
};
using Tallies = std::map<std::string, Tally>;  ///< by Kind::name

/// What a kind may have at most.
struct Limit {
  std::string group;   ///< Kind::group
  double wrong_share;  ///< of its pictures
};
const std::vector<Limit>& trust_limits();

/// Whether a row has more wrong ones than its group may; a group that has no limit may have any.
bool is_over_limit(const Kind& kind, const Tally& tally);

struct TrustRun {
  double usual_ms = 1;  ///< median work of the usual frame
  std::string command;  ///< that makes this page again
};

/// The whole page, one table per group in the order of the kinds; kinds without pictures are left out.
std::string trust_page(const std::vector<Kind>& kinds, const Tallies& tallies, const TrustRun& run);

}  // namespace ninedot::bench
