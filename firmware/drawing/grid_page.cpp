#include "drawing/grid_page.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "base/startup_error.h"
#include "base/units.h"
#include "drawing/page_parts.h"
#include "drawing/paper.h"

namespace ninedot {
namespace {

// Above the grid the printer's margin, below it 8 to the bar and four lines of 5.
constexpr double kTop_mm = kPrinterMargin_mm, kBottom_mm = 34;

}  // namespace

PatternPage make_grid_page(const DotGrid& grid, const std::string& sheet) {
  const Paper paper = parse_sheet(sheet);
  const double pitch_mm = grid.pitch_m / kMetresPerMm;
  // Half a pitch of white around the outer dots.
  const double width_mm = grid.columns * pitch_mm, height_mm = grid.rows * pitch_mm;
  const double factor = std::min(paper.width_mm / width_mm, (paper.height_mm - kTop_mm - kBottom_mm) / height_mm);
  if (factor < 1)
    throw StartupError(
        ExitStatus::kWrongUsage,
        fmt::format("the grid does not fit on {} ({:g} x {:g} mm): use a larger --sheet, or --grid {}x{}@{:g}", sheet,
                    paper.width_mm, paper.height_mm, grid.columns, grid.rows, std::floor(pitch_mm * factor * 10) / 10));

  PatternPage page;
  page.width_mm = paper.width_mm, page.height_mm = paper.height_mm;
  page.title =
      fmt::format("ninedot calibration grid {}x{}, {:g} mm from dot to dot", grid.columns, grid.rows, pitch_mm);
  const PagePoint middle{paper.width_mm / 2, kTop_mm + height_mm / 2};
  for (const PlaneDisc& disc : discs_of(grid)) {
    const Eigen::Vector2d centre_mm = disc.centre_m / kMetresPerMm;
    page.items.emplace_back(
        PageDisc{{middle.x_mm - centre_mm.x(), middle.y_mm - centre_mm.y()}, 2 * disc.radius_m / kMetresPerMm, {}});
  }
  const PagePoint bar{paper.width_mm / 2 - kScaleBar_mm / 2, kTop_mm + height_mm + 8};
  add_scale_bar(page, bar);
  add_lines(page, {bar.x_mm, bar.y_mm + 5},
            {"check: this bar is 100 mm long", page.title,
             "print at 100 % - actual size, not fitted to the page - on matt paper", "mount flat, on glass or board"});
  return page;
}

}  // namespace ninedot
