#include "calibrate_camera/grid_finder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "calibrate_camera/lens_calibration.h"
#include "tests/calibrate_camera/lens_scene.h"
#include "tests/support/random.h"
#include "tests/support/renderer_optics.h"

namespace ninedot {
namespace {

constexpr DotGrid kGrid{9, 7, 0.025};

CameraModel barrel() {
  return {640, 480, 612.3, 611.1, 323.1, 236.4, DistortionModel::kPlumbBob, {-0.21, 0.06, 0.0007, -0.0004, 0.01}};
}

/// \return  the largest distance of a dot from where it truly is; -1: one that is not there. [px]
double worst_px(const CameraModel& camera, const test::CameraPose& pose, const std::vector<SeenDisc>& seen) {
  const std::vector<PlaneDisc> discs = discs_of(kGrid);
  double worst = 0;
  for (const SeenDisc& dot : seen) {
    const PlaneDisc& disc = discs.at(dot.disc);
    const Eigen::Vector2d truth = test::centroid_of_disc_px(test::renderer_lens(camera), pose,
                                                            {disc.centre_m.x(), disc.centre_m.y(), disc.radius_m, 0});
    worst = std::max(worst, (truth - dot.centre_px).norm());
  }
  return worst;
}

TEST(DotGrid, IsReadAsItIsWritten) {
  EXPECT_EQ(parse_dot_grid("9x7@25"), kGrid);
  EXPECT_EQ(parse_dot_grid("11x8@12.5"), (DotGrid{11, 8, 0.0125}));
  for (const char* wrong : {"", "9x7", "9x7@", "9X7@25", "9x7@25mm", "3x7@25", "9x41@25", "9x7@0", "9x7@nan", "-9x7@25",
                            "9x7@2000", " 9x7@25"})
    EXPECT_FALSE(parse_dot_grid(wrong)) << wrong;
}

TEST(DotGrid, HasNoTwoDotsThatTouchAndThreeLargeOnes) {
  const std::vector<PlaneDisc> discs = discs_of(kGrid);
  ASSERT_EQ(discs.size(), 63U);
  EXPECT_EQ(std::ranges::count_if(discs, [](const PlaneDisc& disc) { return disc.radius_m > 0.007; }), 3);
  for (const PlaneDisc& a : discs)
    for (const PlaneDisc& b : discs) {
      if (&a == &b) continue;
      EXPECT_GT((a.centre_m - b.centre_m).norm(), a.radius_m + b.radius_m + 0.2 * kGrid.pitch_m);
    }
}

TEST(GridFinder, NumbersTheDotsFromEverySide) {
  GridFinder finder(640, 480, kGrid);
  test::Random random(1);
  int found = 0;
  for (std::uint64_t i = 0; i < 12; ++i) {
    test::Viewpoint view;
    view.distance_m = random.uniform(0.35, 0.7), view.tilt_rad = random.uniform(0, 0.8);
    view.azimuth_rad = random.uniform(-3, 3), view.roll_rad = random.uniform(-3, 3);
    const test::CameraPose pose = test::look_at_landmark(view);
    const test::Picture picture = test::held_picture(barrel(), pose, test::dot_grid_sheet(kGrid), i);
    const std::vector<SeenDisc> seen = finder.find(picture.view());
    if (seen.empty()) continue;
    ++found;
    EXPECT_GE(seen.size(), 16U);
    EXPECT_LT(worst_px(barrel(), pose, seen), 1) << "view " << i;
  }
  EXPECT_GE(found, 10);
}

TEST(GridFinder, KnowsAPartOfTheGridByItsLargeDots) {
  GridFinder finder(640, 480, kGrid);
  test::Viewpoint near;
  near.distance_m = 0.2, near.roll_rad = 1, near.off_axis_x_rad = 0.1;
  const test::CameraPose pose = test::look_at_landmark(near);
  const std::vector<SeenDisc> seen =
      finder.find(test::held_picture(barrel(), pose, test::dot_grid_sheet(kGrid), 3).view());
  ASSERT_GE(seen.size(), 16U);
  EXPECT_LT(seen.size(), 63U);
  EXPECT_LT(worst_px(barrel(), pose, seen), 1);
}

TEST(GridFinder, TakesNothingElseForTheGrid) {
  GridFinder finder(640, 480, kGrid);
  const test::CameraPose pose = test::look_at_landmark({.distance_m = 0.5, .tilt_rad = 0.3});
  EXPECT_TRUE(finder.find(test::held_picture(barrel(), pose, test::nine_dot_sheet(), 1).view()).empty());
  // A grid without large dots, and one that is too large for its large dots' places.
  EXPECT_TRUE(
      finder.find(test::held_picture(barrel(), pose, test::dot_grid_sheet(9, 7, 0.025, 0.00625), 1).view()).empty());
  EXPECT_TRUE(finder.find(test::held_picture(barrel(), pose, test::dot_grid_sheet({13, 11, 0.02}), 1).view()).empty());
}

TEST(GridFinder, ServesACalibration) {
  GridFinder finder(640, 480, kGrid);
  const std::vector<PlaneDisc> discs = discs_of(kGrid);
  std::vector<SheetView> views;
  test::Holding holding;
  holding.off_centre_share = 0.6, holding.min_distance_m = 0.3, holding.max_distance_m = 0.6;
  for (std::uint64_t i = 0; i < 14; ++i) {
    const test::Picture picture =
        test::held_picture(barrel(), test::held_pose(barrel(), holding, 5, i), test::dot_grid_sheet(kGrid), i);
    if (std::vector<SeenDisc> seen = finder.find(picture.view()); !seen.empty())
      views.push_back(keep_view(picture.view(), SensorKind::kGrey, std::move(seen), discs));
  }
  ASSERT_GE(views.size(), 10U);
  LensCalibrationOptions options;
  options.width_px = 640, options.height_px = 480;
  options.model = DistortionModel::kPlumbBob;
  const auto result = calibrate_lens(discs, std::move(views), options);
  ASSERT_TRUE(result.has_value());
  EXPECT_LT(direction_differences(barrel(), result->fit.camera).median_px(), 0.03);
}

}  // namespace
}  // namespace ninedot
