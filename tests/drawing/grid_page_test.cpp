#include "drawing/grid_page.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <variant>

#include "base/startup_error.h"

namespace ninedot {
namespace {

TEST(GridPage, HasTheDotsWhereTheCalibrationTakesThemToBe) {
  const DotGrid grid{7, 9, 0.025};
  const PatternPage page = make_grid_page(grid, "a4");
  std::vector<PageDisc> dots;
  for (const PageItem& item : page.items)
    if (const auto* disc = std::get_if<PageDisc>(&item)) dots.push_back(*disc);
  ASSERT_EQ(dots.size(), 63U);
  EXPECT_NEAR(dots[1].centre.x_mm - dots[0].centre.x_mm, 25, 1e-9);
  EXPECT_NEAR(dots[7].centre.y_mm - dots[0].centre.y_mm, 25, 1e-9);
  EXPECT_EQ(std::ranges::count_if(dots, [](const PageDisc& dot) { return dot.diameter_mm > 18; }), 3);
  for (const auto& [column, row] : grid.large_dots())
    EXPECT_NEAR(dots[grid.index(column, row)].diameter_mm, 18.75, 1e-9);
  for (const PageDisc& dot : dots) {
    EXPECT_GT(dot.centre.x_mm, 12.5);
    EXPECT_LT(dot.centre.x_mm, page.width_mm - 12.5);
    EXPECT_GT(dot.centre.y_mm, 12.5);
    EXPECT_LT(dot.centre.y_mm, page.height_mm - 40);
  }
}

TEST(GridPage, RefusesAGridThatIsLargerThanThePaperAndNamesOneThatFits) {
  try {
    make_grid_page({9, 7, 0.025}, "a4");
    ADD_FAILURE() << "accepted";
  } catch (const StartupError& error) {
    EXPECT_EQ(error.status, ExitStatus::kWrongUsage);
    EXPECT_NE(std::string(error.what()).find("--grid 9x7@23.3"), std::string::npos) << error.what();
  }
  EXPECT_NO_THROW(make_grid_page({9, 7, 0.0233}, "a4"));
}

}  // namespace
}  // namespace ninedot
