#include "programs/assembly/row_time_text.h"

#include <fmt/format.h>

#include <cmath>

namespace ninedot {

std::string row_time_text(const RowTime& rows) {
  const double mean_us = 1e6 * rows.mean_s, sigma_us = 1e6 * rows.sigma_s;
  const bool is_global = std::abs(rows.mean_s) < 3 * rows.sigma_s;
  const std::string what = is_global
                               ? fmt::format("all rows at once, to {:.1f} us", sigma_us)
                               : fmt::format("{:.1f} us from row to row (1-sigma {:.1f}){}", mean_us, sigma_us,
                                             mean_us < 0 ? ", the last one first: the picture stands on its head" : "");
  constexpr const char* kMeasure = "`ninedot calibrate rolling-shutter` measures it for the configuration";
  switch (rows.source) {
    case RowTimeSource::kTold:
    case RowTimeSource::kOpen:
      return "";
    case RowTimeSource::kSeen:
      return fmt::format("shutter: {}, as moving landmarks show; {}", what, kMeasure);
    case RowTimeSource::kContradicted:
      break;
  }
  return fmt::format("shutter: camera.row_time_us is wrong: moving landmarks show {}; poses go by that; {}", what,
                     kMeasure);
}

}  // namespace ninedot
