#pragma once
/// What somebody meant who mistyped a word. Not for the frame path: allocates.
#include <algorithm>
#include <cstddef>
#include <limits>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace ninedot {

/// Levenshtein's distance: how many letters are to be put in, left out or replaced to make `b` of `a` [1].
inline std::size_t mistakes_between(std::string_view a, std::string_view b) {
  std::vector<std::size_t> before(b.size() + 1), row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) before[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j)
      row[j] = std::min({before[j] + 1, row[j - 1] + 1, before[j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
    std::swap(before, row);
  }
  return before[b.size()];
}

/// Which of the known words was meant: "; did you mean 'rate_hz'?" or nothing. Keeps views of what it is given.
class Suggestion {
 public:
  explicit Suggestion(std::string_view typed) : typed_(typed) {}
  void consider(std::string_view known) {
    const std::size_t mistakes = mistakes_between(typed_, known);
    const bool is_start = typed_.size() >= 3 && known.starts_with(typed_);  // the unit was forgotten: rate, width
    const std::size_t cost = is_start ? 1 : mistakes;
    if (cost >= best_cost_ || (!is_start && cost * 3 > known.size())) return;
    best_cost_ = cost;
    best_ = known;
  }
  std::string text() const { return best_.empty() ? std::string() : "; did you mean '" + std::string(best_) + "'?"; }

 private:
  std::string_view typed_, best_;
  std::size_t best_cost_ = std::numeric_limits<std::size_t>::max();
};

}  // namespace ninedot
