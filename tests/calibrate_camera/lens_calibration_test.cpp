// Lenses that are known, and what a calibration says of them.
#include "calibrate_camera/lens_calibration.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "calibrate_camera/lens_parameters.h"
#include "calibrate_camera/lens_prior.h"
#include "calibrate_camera/sheet_finder.h"
#include "calibrate_camera/sufficiency.h"
#include "tests/calibrate_camera/lens_scene.h"
#include "tests/support/random.h"

namespace ninedot {
namespace {

const std::vector<PlaneDisc> kDiscs = discs_of(LandmarkGeometry{});

CameraModel barrel() {
  return {640, 480, 612.3, 611.1, 323.1, 236.4, DistortionModel::kPlumbBob, {-0.21, 0.06, 0.0007, -0.0004, 0.01}};
}
CameraModel fisheye() {
  return {640, 480, 262.4, 262.9, 317.8, 241.6, DistortionModel::kEquidistant, {0.021, -0.009, 0.004, -0.001}};
}

LensCalibrationOptions options_for(const CameraModel& camera) {
  LensCalibrationOptions options;
  options.width_px = camera.width_px, options.height_px = camera.height_px;
  return options;
}

/// \param pose  of the index
template <typename Pose>
std::vector<SheetView> views_from(const CameraModel& camera, std::size_t count, std::uint64_t seed, Pose&& pose) {
  LandmarkFinder finder(usual_camera(camera.width_px, camera.height_px), LandmarkGeometry{});
  std::vector<SheetView> views;
  for (std::uint64_t i = 0; i < count; ++i) {
    const test::Picture picture =
        test::held_picture(camera, pose(i), test::nine_dot_sheet(), test::random_bits(seed, i));
    if (std::vector<SeenDisc> seen = finder.find(picture.view()); !seen.empty())
      views.push_back(keep_view(picture.view(), SensorKind::kGrey, std::move(seen), kDiscs));
  }
  return views;
}

std::vector<SheetView> rendered_views(const CameraModel& camera, const test::Holding& holding, std::size_t count,
                                      std::uint64_t seed) {
  return views_from(camera, count, seed, [&](std::uint64_t i) { return test::held_pose(camera, holding, seed, i); });
}

/// With a lens that is known nothing is left to a start: what remains is the estimate and its covariance.
LensFit fit_of_perfect_views(const CameraModel& camera, std::size_t count, std::uint64_t seed,
                             std::vector<SheetView>& views) {
  LensFit fit{camera, {}, 0, 0};
  for (std::uint64_t i = 0; views.size() < count; ++i) {
    const test::CameraPose pose = test::held_pose(camera, {}, seed, i);
    SheetView view = test::perfect_view(camera, pose, kDiscs, 0.02, test::random_bits(seed, i));
    if (view.seen.size() < 5) continue;
    views.push_back(std::move(view));
    fit.views.push_back({test::sheet_before(pose), 0});
  }
  EXPECT_TRUE(adjust_lens(kDiscs, views, fit, {}));
  return fit;
}

TEST(LensCalibration, KnowsALensToAFewHundredthsOfAPixelFromThirtyPictures) {
  std::vector<SheetView> views = rendered_views(barrel(), {}, 30, 1);
  ASSERT_GE(views.size(), 25U);
  const auto result = calibrate_lens(kDiscs, std::move(views), options_for(barrel()));
  ASSERT_TRUE(result.has_value());
  EXPECT_EQ(result->fit.camera.model, DistortionModel::kPlumbBob);
  const DirectionErrors off = direction_differences(barrel(), result->fit.camera);
  EXPECT_LT(off.median_px(), 0.05);
  EXPECT_LT(off.max_px(), 0.15);
  // And it says so itself, neither much better nor much worse.
  EXPECT_LT(result->directions.median_px(), 0.03);
  EXPECT_GT(result->directions.median_px(), 0.3 * off.median_px());
  EXPECT_TRUE(what_lens_lacks(*result).empty());
}

TEST(LensCalibration, TakesAFisheyeForOneWithoutBeingTold) {
  test::Holding near;
  near.min_distance_m = 0.16, near.max_distance_m = 0.4;
  const auto result = calibrate_lens(kDiscs, rendered_views(fisheye(), near, 36, 2), options_for(fisheye()));
  ASSERT_TRUE(result.has_value());
  EXPECT_EQ(result->fit.camera.model, DistortionModel::kEquidistant);
  EXPECT_LT(direction_differences(fisheye(), result->fit.camera).median_px(), 0.05);
  ASSERT_EQ(result->tried.size(), 3U);
  EXPECT_NE(result->tried[0].model, DistortionModel::kPlumbBob);
  const auto plain = std::ranges::find(result->tried, DistortionModel::kPlumbBob, &TriedModel::model);
  ASSERT_NE(plain, result->tried.end());
  EXPECT_GT(plain->held_out_px, 1.1 * result->tried[0].held_out_px);
}

TEST(LensCalibration, KeepsToTheModelThatItIsTold) {
  LensCalibrationOptions options = options_for(barrel());
  options.model = DistortionModel::kEquidistant;
  const auto result = calibrate_lens(kDiscs, rendered_views(barrel(), {}, 16, 3), options);
  ASSERT_TRUE(result.has_value());
  EXPECT_EQ(result->fit.camera.model, DistortionModel::kEquidistant);
  EXPECT_TRUE(result->tried.empty());
}

TEST(LensCalibration, IsNotMisledByAWrongGuess) {
  LensCalibrationOptions options = options_for(barrel());
  options.guess = barrel();
  options.guess->fx_px = options.guess->fy_px = 1400, options.guess->k = {0.3, 0, 0, 0, 0};
  const auto result = calibrate_lens(kDiscs, rendered_views(barrel(), {}, 16, 4), options);
  ASSERT_TRUE(result.has_value());
  EXPECT_NEAR(result->fit.camera.fx_px, barrel().fx_px, 1);
}

TEST(LensCalibration, LeavesOutAViewOfAnotherLens) {
  std::vector<SheetView> views = rendered_views(barrel(), {}, 16, 5);
  CameraModel zoomed = barrel();
  zoomed.fx_px *= 1.3;  // one way only: no pose makes up for it
  const std::size_t good = views.size();
  for (SheetView& view : rendered_views(zoomed, {}, 3, 6)) views.push_back(std::move(view));
  const std::size_t bad = views.size() - good;
  ASSERT_GE(bad, 1U);
  const auto result = calibrate_lens(kDiscs, std::move(views), options_for(barrel()));
  ASSERT_TRUE(result.has_value());
  EXPECT_GE(result->left_out, static_cast<int>(bad));
  EXPECT_NEAR(result->fit.camera.fx_px, barrel().fx_px, 1);
}

TEST(LensCalibration, EndsWhenItIsToldTo) {
  LensCalibrationOptions options = options_for(barrel());
  int asked = 0;
  options.go_on = [&asked](std::string_view) { return ++asked < 40; };
  EXPECT_FALSE(calibrate_lens(kDiscs, rendered_views(barrel(), {}, 12, 7), options).has_value());
  EXPECT_LT(asked, 60);
}

TEST(LensAdjustment, FindsTheLensExactlyWhereOutlinesAreExact) {
  for (const CameraModel& camera : {barrel(), fisheye()}) {
    std::vector<SheetView> views;
    LensFit fit{camera, {}, 0, 0};
    for (std::uint64_t i = 0; i < 12; ++i) {
      test::Holding holding;
      holding.min_distance_m *= camera.fx_px / 612, holding.max_distance_m *= camera.fx_px / 612;
      const test::CameraPose pose = test::held_pose(camera, holding, 8, i);
      SheetView view = test::perfect_view(camera, pose, kDiscs, 0, i);
      if (view.seen.size() < 5) continue;
      for (EdgePoint& edge : view.edges) edge.sigma_px = 0.01;
      views.push_back(std::move(view));
      fit.views.push_back({test::sheet_before(pose), 0});
    }
    fit.camera.fx_px *= 1.01, fit.camera.cx_px += 2, fit.camera.k[0] += 0.01;
    ASSERT_TRUE(adjust_lens(kDiscs, views, fit, {}));
    EXPECT_NEAR(fit.camera.fx_px, camera.fx_px, 0.01);
    EXPECT_LT(direction_differences(camera, fit.camera).max_px(), 0.01);
  }
}

// Errors made in sigmas, over independent trials: their mean square is 1 for each parameter.
TEST(LensCovariance, IsThatOfTheErrorsMade) {
  constexpr int kTrials = 100;
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(9);
  double directions = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<SheetView> views;
    const LensFit fit = fit_of_perfect_views(barrel(), 16, 9000 + static_cast<std::uint64_t>(trial), views);
    const LensCovariance covariance = lens_covariance(kDiscs, views, fit);
    const Eigen::VectorXd error = parameters_of(fit.camera) - parameters_of(barrel());
    squares += error.cwiseAbs2().cwiseQuotient(covariance.matrix.diagonal());
    const DirectionErrors said = direction_errors(fit.camera, covariance.matrix);
    const DirectionErrors made = direction_differences(barrel(), fit.camera);
    double ratio = 0;
    for (std::size_t i = 0; i < said.sigma_px.size(); ++i)
      ratio += made.sigma_px[i] * made.sigma_px[i] / (said.sigma_px[i] * said.sigma_px[i]);
    directions += ratio / static_cast<double>(said.sigma_px.size());
  }
  SCOPED_TRACE(testing::Message() << (squares / kTrials).transpose() << ", directions " << directions / kTrials);
  for (const double mean_square : squares / kTrials) {
    EXPECT_GT(mean_square, 0.5);
    EXPECT_LT(mean_square, 1.6);
  }
  EXPECT_GT(directions / kTrials, 0.6);
  EXPECT_LT(directions / kTrials, 1.4);
}

// Another lens than any that the prior was weighed on: a depth camera's. What is believed still shows in single
// coefficients, since all trials are off the same way.
TEST(LensCovariance, OfARationalLensHoldsForEachCoefficient) {
  constexpr int kTrials = 6;
  const CameraModel lens{640,
                         480,
                         420,
                         420.6,
                         322.7,
                         238.1,
                         DistortionModel::kRationalPolynomial,
                         {4.9, 3.1, 0.0003, -0.0002, 0.16, 5.2, 4.6, 0.9}};
  Eigen::VectorXd squares = Eigen::VectorXd::Zero(12);
  double worst_px = 0;
  for (int trial = 0; trial < kTrials; ++trial) {
    std::vector<SheetView> views;
    const LensFit fit = fit_of_perfect_views(lens, 24, 12000 + static_cast<std::uint64_t>(trial), views);
    const Eigen::VectorXd error = parameters_of(fit.camera) - parameters_of(lens);
    squares += error.cwiseAbs2().cwiseQuotient(lens_covariance(kDiscs, views, fit).matrix.diagonal());
    worst_px = std::max(worst_px, direction_differences(lens, fit.camera).max_px());
  }
  SCOPED_TRACE(testing::Message() << (squares / kTrials).cwiseSqrt().transpose() << ", directions " << worst_px);
  EXPECT_LT(std::sqrt(squares.sum() / (12 * kTrials)), 1.5);
  for (const double mean_square : squares / kTrials) EXPECT_LT(mean_square, 3 * 3);
  EXPECT_LT(worst_px, 2) << "a pole in the picture";
}

TEST(LensPrior, HasTheDerivativesOfItsResiduals) {
  CameraModel rational = barrel();
  rational.model = DistortionModel::kRationalPolynomial;
  rational.k = {1.6, 0.35, 0.0004, -0.0003, 0.012, 1.95, 0.72, 0.06};
  for (const CameraModel& lens : {barrel(), fisheye(), rational}) {
    const LensPrior prior(lens);
    const Eigen::VectorXd values = parameters_of(lens);
    Eigen::VectorXd at, ahead, behind;
    Eigen::MatrixXd jacobian;
    ASSERT_TRUE(prior.evaluate(values, at, &jacobian));
    ASSERT_EQ(jacobian.rows(), prior.count());
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      const Eigen::VectorXd step = 1e-5 * Eigen::VectorXd::Unit(values.size(), i);
      ASSERT_TRUE(prior.evaluate(values + step, ahead, nullptr) && prior.evaluate(values - step, behind, nullptr));
      EXPECT_LT(((ahead - behind) / 2e-5 - jacobian.col(i)).lpNorm<Eigen::Infinity>(), 1e-6) << i;
    }
  }
}

TEST(LensPrior, RefusesAPoleInThePicture) {
  CameraModel lens = barrel();
  lens.model = DistortionModel::kRationalPolynomial;
  lens.k = {};
  Eigen::VectorXd residuals, values = parameters_of(lens);
  ASSERT_TRUE(LensPrior(lens).evaluate(values, residuals, nullptr));
  values(kPlainIntrinsics + 5) = -4;  // 1 - 4 r^2 is zero half-way to the corner
  EXPECT_FALSE(LensPrior(lens).evaluate(values, residuals, nullptr));
}

TEST(LensCovariance, GrowsWithWhatViewsHaveInCommonThatTheModelDoesNotExplain) {
  std::vector<SheetView> views;
  LensFit fit = fit_of_perfect_views(barrel(), 24, 31, views);
  EXPECT_LT(lens_covariance(kDiscs, views, fit).variance_factor, 1.6);
  // Sheets that are stretched one way, each by another 0.1 %: all outlines of a view say the same wrong thing.
  test::Random random(5);
  for (std::size_t i = 0; i < views.size(); ++i) {
    const double stretch = 1e-3 * random.normal();
    for (EdgePoint& edge : views[i].edges)
      edge.at_px.x() += stretch * (edge.at_px.x() - views[i].seen[0].centre_px.x());
  }
  ASSERT_TRUE(adjust_lens(kDiscs, views, fit, {}));
  EXPECT_GT(lens_covariance(kDiscs, views, fit).variance_factor, 3);
}

TEST(DirectionErrors, LeaveOutATurnOfTheCamera) {
  // Over a narrow field a shifted centre is a turn of the camera, but for what the tangent bends.
  CameraModel tele = barrel();
  tele.fx_px = tele.fy_px = 5000, tele.k = {};
  CameraModel shifted = tele;
  shifted.cx_px += 3;
  EXPECT_LT(direction_differences(tele, shifted).max_px(), 0.05);
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(9, 9);
  covariance(2, 2) = 9;
  EXPECT_LT(direction_errors(tele, covariance).max_px(), 0.05);
  covariance(0, 0) = 25;  // 5 px of 5000: a thousandth of the way from the middle
  EXPECT_NEAR(direction_errors(tele, covariance).at(0, 9), 0.32, 0.02);
}

TEST(Sufficiency, NamesThePartsOfThePictureThatNoViewShows) {
  std::vector<SheetView> views;
  for (int i = 0; i < 12; ++i) {
    SheetView view;
    for (std::size_t part = 0; part < 9; ++part)
      if (part != 6)
        view.seen.push_back(
            {part, {100.0 + 200 * static_cast<double>(part % 3), 80.0 + 160 * static_cast<double>(part / 3)}});
    views.push_back(view);
  }
  const std::vector<std::string> lacks = what_views_lack(views, 12, 640, 480);
  ASSERT_EQ(lacks.size(), 1U);
  EXPECT_EQ(lacks[0].rfind("no views in the lower left", 0), 0U) << lacks[0];
  views.resize(5);
  EXPECT_EQ(what_views_lack(views, 5, 640, 480)[0].rfind("five views are too few", 0), 0U);
  views.resize(1);
  EXPECT_EQ(what_views_lack(views, 40, 640, 480)[0].rfind("all 40 pictures show the sheet in one place", 0), 0U);
}

TEST(Sufficiency, RefusesViewsThatAreAllFrontal) {
  LensCalibrationOptions options = options_for(barrel());
  options.model = DistortionModel::kPlumbBob;
  const auto result = calibrate_lens(
      kDiscs, views_from(barrel(), 24, 9, [](std::uint64_t i) { return test::frontal_pose(9, i); }), options);
  if (!result) return;  // no lens at all is a refusal too, of calibrate_lens
  const std::vector<std::string> lacks = what_lens_lacks(*result);
  ASSERT_FALSE(lacks.empty());
  EXPECT_EQ(lacks[0].rfind("focal length uncertain by ", 0), 0U) << lacks[0];
  EXPECT_EQ(lacks.size(), 1U) << "without it no direction is known; the parts of the picture are not to blame: "
                              << lacks[1];
}

TEST(Sufficiency, RefusesViewsOfTwoLenses) {
  LensCalibration calibration;
  calibration.fit.camera = barrel();
  calibration.covariance.matrix = 1e-4 * Eigen::MatrixXd::Identity(9, 9);
  calibration.directions = direction_errors(barrel(), Eigen::MatrixXd::Zero(9, 9));
  calibration.views.resize(50);
  calibration.left_out = 20, calibration.contradicting = 8;
  EXPECT_TRUE(what_lens_lacks(calibration).empty());
  calibration.contradicting = 9;
  const std::vector<std::string> lacks = what_lens_lacks(calibration);
  ASSERT_EQ(lacks.size(), 1U);
  EXPECT_EQ(lacks[0].rfind("9 of 59 views contradict the others", 0), 0U) << lacks[0];
}

}  // namespace
}  // namespace ninedot
