#pragma once
/// docs/accuracy.md and its plots.
#include <string>
#include <vector>

#include "tests/bench/accuracy_trials.h"

namespace ninedot::bench {

/// One table: a condition varied, the rest at its default.
struct Sweep {
  std::string name;  ///< of the plot's file: accuracy-NAME.svg; empty: no plot
  std::string heading;
  std::string varied;  ///< what the first column is, with its unit
  std::string note;    ///< a paragraph under the heading; may be empty
  std::vector<Condition> conditions;
  std::vector<Outcome> outcomes;  ///< one per condition
};

/// The whole page, in Markdown. \param trials  frames per row
std::string accuracy_page(const std::vector<Sweep>& sweeps, int trials);

/// Error of both solvers and the bound, in mm on a logarithmic axis, over the varied quantity.
std::string accuracy_plot(const Sweep& sweep);

}  // namespace ninedot::bench
