// Which lens model is taken, given a fit of another one.
#include "calibrate_camera/model_choice.h"

#include <gtest/gtest.h>

#include "calibrate_camera/lens_uncertainty.h"
#include "tests/calibrate_camera/lens_scene.h"
#include "tests/support/random.h"

namespace ninedot {
namespace {

const std::vector<PlaneDisc> kDiscs = discs_of(LandmarkGeometry{});

/// Outlines as a lens shows them, off by 0.02 px, with the sheets where they are.
LensFit true_fit(const CameraModel& camera, std::size_t count, std::uint64_t seed, std::vector<SheetView>& views) {
  LensFit fit{camera, {}, 0, 0};
  test::Holding holding;
  holding.min_distance_m *= camera.fx_px / 612, holding.max_distance_m *= camera.fx_px / 612;
  for (std::uint64_t i = 0; views.size() < count; ++i) {
    const test::CameraPose pose = test::held_pose(camera, holding, seed, i);
    SheetView view = test::perfect_view(camera, pose, kDiscs, 0.02, test::random_bits(seed, i));
    if (view.seen.size() < 5) continue;
    views.push_back(std::move(view));
    fit.views.push_back({test::sheet_before(pose), 0});
  }
  return fit;
}

// No polynomial without a denominator bends as this lens does, but a fisheye's nearly: that is where a calibration
// comes from. One view that another model misses by far must not be all that is compared.
TEST(ModelChoice, FindsARationalLensFromAFisheyesFit) {
  const CameraModel lens{640,
                         480,
                         388.1,
                         388.9,
                         321.7,
                         238.1,
                         DistortionModel::kRationalPolynomial,
                         {1.6, 0.35, 0.0004, -0.0003, 0.012, 1.95, 0.72, 0.06}};
  std::vector<SheetView> views;
  LensFit fit = true_fit(lens, 24, 31, views);
  fit.camera.model = DistortionModel::kEquidistant, fit.camera.k = {};
  ASSERT_TRUE(adjust_lens(kDiscs, views, fit, {}));
  fit.floor_px = unexplained_px(kDiscs, views, fit);
  std::vector<TriedModel> tried;
  const auto chosen = choose_model(kDiscs, views, fit, {{}, [](std::string_view) { return true; }}, tried);
  ASSERT_TRUE(chosen.has_value());
  EXPECT_EQ(chosen->camera.model, DistortionModel::kRationalPolynomial);
  ASSERT_EQ(tried.size(), 3U);
  EXPECT_EQ(tried[0].model, DistortionModel::kRationalPolynomial);
  EXPECT_LT(tried[0].held_out_px, 0.03);
  EXPECT_LT(direction_differences(lens, chosen->camera).median_px(), 0.05);
}

}  // namespace
}  // namespace ninedot
