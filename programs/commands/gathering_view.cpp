#include "programs/commands/gathering_view.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string_view>

namespace ninedot {
namespace {

/// The picture in nine parts, as the camera sees it.
std::string map_rows(const GatheringState& state) {
  std::string rows;
  for (std::size_t part = 0; part < state.tally.parts.size(); ++part) {
    const std::string count = state.tally.parts[part] == 0 ? "." : std::to_string(state.tally.parts[part]);
    rows += state.part == part ? fmt::format("  [{:>3} ]", count) : fmt::format("   {:>3}  ", count);
    if (part % 3 == 2) rows += '\n';
  }
  return rows;
}

std::string hint(const GatheringState& state) {
  switch (state.looked) {
    case Looked::kNoSheet:
      return "no sheet in sight: whole in the picture, evenly lit, not too far away";
    case Looked::kMoving:
      return "hold still";
    case Looked::kBlurred:
      return "blurred: focus the lens, or give more light";
    case Looked::kTaken:
      return "taken";
    case Looked::kSeenBefore:
      break;
  }
  return state.wanted.empty() ? "have that: move on" : "have that: move on, to " + state.wanted.front();
}

std::string so_far(const GatheringState& state) {
  return fmt::format("{} {}; wanted: {}", state.tally.views, state.tally.views == 1 ? "view" : "views",
                     state.wanted.empty() ? "nothing" : fmt::format("{}", fmt::join(state.wanted, ", ")));
}

/// Broken between words; what goes on is indented. \return  each line with its end
std::string wrapped(std::string_view text, std::size_t columns) {
  constexpr std::string_view kIndent = "  ";
  std::string lines;
  std::size_t used = 0;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    const std::string_view word = text.substr(at, end - at);
    if (used > kIndent.size() && used + 1 + word.size() > columns)
      lines += '\n', lines += kIndent, used = kIndent.size();
    else if (used > 0)
      lines += ' ', ++used;
    lines += word, used += word.size();
    at = end + 1;
  }
  return lines + '\n';
}

}  // namespace

std::string gathering_table(const GatheringState& state, std::size_t columns) {
  std::string lacks;
  for (const std::string& lack : state.lens_lacks) lacks += wrapped(lack, columns);
  return fmt::format(
      "{}"
      "{}\n"
      "{}"
      "  views there; [ ]: the sheet now\n\n"
      "{}\n"
      "Ctrl-C ends, with what there is\n",
      wrapped(so_far(state), columns), lacks, map_rows(state), hint(state));
}

std::string gathering_line(const GatheringState& state) {
  if (state.lens_lacks.empty()) return so_far(state);
  return fmt::format("{} ({})", so_far(state), fmt::join(state.lens_lacks, "; "));
}

}  // namespace ninedot
