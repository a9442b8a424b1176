#pragma once
/// The value that half of all lie below.
#include <algorithm>
#include <cstddef>
#include <vector>

namespace ninedot {

/// Of an even number the upper one of the middle two; of none 0.
/// \param values  all of one unit [1] \return  in that unit [1]
/// Memory: the list. Threads: pure.
inline double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

}  // namespace ninedot
