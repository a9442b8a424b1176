#include "pose/outline_sums.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <numbers>

#include "tests/support/rendered_truth.h"

namespace ninedot {
namespace {

double squares(const OutlinePixels& pixels, const OutlineState& state) {
  double sum = 0;
  const LandmarkGeometry landmark;
  GroupFitter fitter(pixels, landmark, state, Asked::kLightOnly);
  GroupFit fit;
  for (const OutlineGroup& group : pixels.groups) {
    fitter.fit(group, fit);
    sum += fit.squared_residuals;
  }
  return sum;
}

/// \param tone  of the state; 0: it is none of the unknowns
void expect_gradient_of_squares(double tone) {
  test::Scene scene;
  scene.camera = test::look_at_landmark({.distance_m = 1.0, .tilt_rad = 0.5, .azimuth_rad = 0.7});
  set_noise(scene.sensor, 1.0);
  const test::Picture picture = test::render(scene, 1);
  OutlineState state;
  state.T_camera_landmark = test::sheet_before(scene.camera);
  state.blur_px2 = 0.4;
  UnknownVector off = UnknownVector::Zero();
  off << 2e-4, -1e-4, 2e-4, 1e-4, -2e-4, 1e-3, 0, 0, 0, 0, tone;  // a fraction of a pixel
  state.apply(off);

  const CameraModel camera;
  const RayTable rays(camera);
  OutlinePixels pixels(12000);
  collect_outline_pixels(picture.view(), camera, rays, LandmarkGeometry{}, state.T_camera_landmark, 3, 1, {}, {},
                         pixels);
  pixels.has_tone = tone != 0;
  pixels.tone_bends.fill(srgb_bend(190, 145));
  ASSERT_GE(pixels.groups.size(), kDotCount);

  UnknownVector gradient = UnknownVector::Zero();
  UnknownMatrix normal = UnknownMatrix::Zero();
  const LandmarkGeometry landmark;
  GroupFitter fitter(pixels, landmark, state, Asked::kState);
  GroupFit fit;
  for (const OutlineGroup& group : pixels.groups) {
    fitter.fit(group, fit);
    ASSERT_TRUE(fit.usable);
    gradient += fit.gradient;
    normal += fit.normal;
  }
  // From the sheet's axes to the camera's, which a step is along.
  UnknownMatrix turn = UnknownMatrix::Identity();
  turn.block<3, 3>(0, 0) = turn.block<3, 3>(3, 3) = state.T_camera_landmark.rotation;
  gradient = (turn * gradient).eval();
  normal = (turn * normal * turn.transpose()).eval();
  // Steps that move outlines by about a hundredth of a pixel.
  const std::array<double, kUnknowns> steps{1e-5, 1e-5, 1e-5, 1e-5, 1e-5, 1e-4, 0.01, 0.01, 0.01, 0.01, 0.01};
  for (int k = 0; k < kUnknowns; ++k) {
    UnknownVector step = UnknownVector::Zero();
    step(k) = steps[static_cast<std::size_t>(k)];
    OutlineState ahead = state, behind = state;
    ahead.apply(step);
    behind.apply(-step);
    const double numeric = -(squares(pixels, ahead) - squares(pixels, behind)) / (4 * step(k));
    // The Jacobian leaves out how the outline's steepness changes with the pose: second order in the distance.
    const double scale = std::sqrt(normal(k, k) * squares(pixels, state));
    EXPECT_NEAR(gradient(k), numeric, 0.03 * scale) << "unknown " << k;
    EXPECT_EQ(normal(k, k) > 0, k != kToneUnknown || tone != 0) << "unknown " << k;
  }
}

TEST(OutlineSums, GradientEqualsCentralDifferencesOfTheSquaredResiduals) { expect_gradient_of_squares(0); }

TEST(OutlineSums, GradientEqualsCentralDifferencesOfTheSquaredResidualsOfABentTone) { expect_gradient_of_squares(0.7); }

/// Columns of one group as a matrix, a pixel in each row.
Eigen::MatrixXd columns_of(const OutlinePixels& pixels, const OutlineGroup& group, const OutlineState& state) {
  const LandmarkGeometry landmark;
  const DotView view(pixels, landmark, state, group.dot);
  const BlurredDisc disc(pixels, landmark, state, group.dot, Asked::kState);
  const DotView view_before(pixels, landmark, before_interpolation(state), group.dot);
  const BlurredDisc disc_before(pixels, landmark, before_interpolation(state), group.dot, Asked::kState);
  Eigen::MatrixXd all(group.count, kColumns);
  for (std::int32_t at = 0; at < group.count; ++at) {
    ColumnBatches batches;
    const PixelRange range{static_cast<std::size_t>(group.first + at), 1};
    fill_columns(pixels, group, view, disc, range, Asked::kState, batches);
    fill_pattern_columns(pixels, view_before, disc_before, range, batches);
    for (std::size_t c = 0; c < kColumns; ++c)
      all(at, static_cast<Eigen::Index>(c)) = static_cast<double>(batches[0][c][0]);
  }
  // Grey levels are less the group's first one.
  for (std::int32_t at = 0; at < group.count; ++at)
    all(at, kGreyColumn) = static_cast<double>(pixels.luma[static_cast<std::size_t>(group.first + at)] -
                                               pixels.luma[static_cast<std::size_t>(group.first)]);
  return all;
}

/// What is left of `columns` beyond what `own` can make of them, where each of `own` costs its ridge.
Eigen::MatrixXd left_of(const Eigen::MatrixXd& columns, const Eigen::MatrixXd& own, const Eigen::VectorXd& ridge) {
  Eigen::MatrixXd products = own.transpose() * own;
  products.diagonal() += ridge;
  return columns.transpose() * columns - columns.transpose() * own * products.ldlt().solve(own.transpose() * columns);
}

/// As if a colour camera had seen the scene.
OutlinePixels pixels_of_pattern(const test::Scene& scene, const OutlineState& state) {
  const test::Picture picture = test::render(scene, 1);
  ImageView luma = picture.view();
  luma.has_pattern = true;
  const CameraModel camera;
  OutlinePixels pixels(12000);
  collect_outline_pixels(luma, camera, RayTable(camera), LandmarkGeometry{}, state.T_camera_landmark, 3, 1, {}, {},
                         pixels);
  return pixels;
}

TEST(OutlineSums, PatternChangesSignFromOnePixelToTheNext) {
  test::Scene scene;
  scene.camera = test::look_at_landmark({.distance_m = 3.0});
  OutlineState state;
  state.T_camera_landmark = test::sheet_before(scene.camera);
  OutlinePixels pixels = pixels_of_pattern(scene, state);
  const auto pattern = [&] { return columns_of(pixels, pixels.groups[0], state).leftCols<kPatternColumns>().eval(); };
  const auto here = pattern();
  for (float& x_px : pixels.x_px) x_px += 1;
  const auto beside = pattern();
  for (float& y_px : pixels.y_px) y_px += 1;
  const auto across = pattern();
  for (const Eigen::Index by_column : {0, 2}) {
    EXPECT_GT(here.col(by_column).norm(), 0.01);
    EXPECT_EQ(beside.col(by_column), -here.col(by_column));
    EXPECT_EQ(across.col(by_column), -here.col(by_column));
  }
  for (const Eigen::Index by_row : {1, 3}) {
    EXPECT_GT(here.col(by_row).norm(), 0.01);
    EXPECT_EQ(beside.col(by_row), here.col(by_row));
    EXPECT_EQ(across.col(by_row), -here.col(by_row));
  }
}

TEST(OutlineSums, PatternIsEliminatedLikeTheLight) {
  test::Scene scene;
  scene.camera = test::look_at_landmark({.distance_m = 3.0, .tilt_rad = 0.5, .azimuth_rad = 0.7});
  set_noise(scene.sensor, 2.0);
  OutlineState state;
  state.T_camera_landmark = test::sheet_before(scene.camera);
  const OutlinePixels pixels = pixels_of_pattern(scene, state);
  const LandmarkGeometry landmark;
  GroupFitter fitter(pixels, landmark, state, Asked::kState), light_only(pixels, landmark, state, Asked::kLightOnly);
  for (const OutlineGroup& group : pixels.groups) {
    ASSERT_TRUE(group.whole_dot);
    GroupFit fit, light;
    fitter.fit(group, fit);
    light_only.fit(group, light);
    ASSERT_TRUE(fit.usable && light.usable);
    const Eigen::MatrixXd all = columns_of(pixels, group, state);
    const Eigen::MatrixXd asked = all.middleCols<kToneUnknown + 1>(kStateColumn);
    Eigen::MatrixXd own = all.middleCols<5>(kPaperColumn);
    Eigen::VectorXd ridge(5);
    ridge << 0, 0, 1e-3, 1e-3, 1e-3;
    const Eigen::MatrixXd without = left_of(asked, own, ridge);
    const double variance_lsb2 = without(kToneUnknown, kToneUnknown) / (group.count - 5);
    own.conservativeResize(Eigen::NoChange, 9);
    own.rightCols<4>() = all.leftCols<kPatternColumns>();
    ridge.conservativeResize(9);
    ridge.tail<4>().setConstant(variance_lsb2 / std::pow(0.1 * fit.contrast_lsb, 2));
    const Eigen::MatrixXd with = left_of(asked, own, ridge);
    EXPECT_NEAR(fit.squared_residuals, with(kToneUnknown, kToneUnknown), 1e-3 * with(kToneUnknown, kToneUnknown));
    EXPECT_NEAR(light.squared_residuals, fit.squared_residuals, 1e-6 * fit.squared_residuals);
    EXPECT_LT(fit.squared_residuals, without(kToneUnknown, kToneUnknown));
    const Eigen::MatrixXd normal =
        fit.contrast_lsb * fit.contrast_lsb * with.topLeftCorner<kToneUnknown, kToneUnknown>();
    const Eigen::VectorXd gradient = fit.contrast_lsb * with.col(kToneUnknown).head<kToneUnknown>();
    for (Eigen::Index i = 0; i < kToneUnknown; ++i) {
      const double scale = std::sqrt(normal(i, i));
      EXPECT_NEAR(fit.gradient(i), gradient(i), 1e-3 * scale * std::sqrt(fit.squared_residuals)) << i;
      for (Eigen::Index j = 0; j < kToneUnknown; ++j)
        EXPECT_NEAR(fit.normal(i, j), normal(i, j), 1e-3 * scale * std::sqrt(normal(j, j))) << i << ", " << j;
    }
  }
}

TEST(OutlineState, BlurStaysPossible) {
  OutlineState state;
  UnknownVector step = UnknownVector::Zero();
  step(7) = -10, step(8) = 5, step(9) = -5;
  state.apply(step);
  EXPECT_GT(state.blur_px2, 0);
  EXPECT_LT(std::hypot(state.blur_cos_px2, state.blur_sin_px2), state.blur_px2);
}

}  // namespace
}  // namespace ninedot
