#pragma once
/// docs/accuracy.md and its plots.
#include <string>
#include <vector>

#include "tests/bench/accuracy_rooms.h"
#include "tests/bench/accuracy_trials.h"

namespace ninedot::bench {

/// One table: a condition varied, the rest at its default.
template <typename ConditionOfRow, typename OutcomeOfRow>
struct SweepOf {
  using Row = ConditionOfRow;
  std::string name;  ///< of the plot's file: accuracy-NAME.svg; empty: no plot
  std::string heading;
  std::string varied;  ///< what the first column is, with its unit
  std::string note;    ///< a paragraph under the heading; may be empty
  std::vector<ConditionOfRow> conditions;
  std::vector<OutcomeOfRow> outcomes;  ///< one per condition
};
using Sweep = SweepOf<Condition, Outcome>;              ///< of single frames
using RoomSweep = SweepOf<RoomCondition, RoomOutcome>;  ///< of walks

/// The page in Markdown has two parts, which can be made anew by themselves: `rooms_part` begins with this line.
inline constexpr const char* kRoomsHeading = "## Rooms\n";

/// The first part, with the page's title. \param trials  frames per row
std::string accuracy_page(const std::vector<Sweep>& sweeps, int trials);
std::string rooms_part(const std::vector<RoomSweep>& sweeps);

/// Errors and the bound, in mm on a logarithmic axis, over the varied quantity.
std::string accuracy_plot(const Sweep& sweep);
std::string accuracy_plot(const RoomSweep& sweep);

/// Three digits, whatever the size.
std::string three_digits(double value);

}  // namespace ninedot::bench
