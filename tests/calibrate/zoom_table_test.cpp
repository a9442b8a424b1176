#include "calibrate/zoom_table.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <random>

#include "tests/support/zoom_lens.h"

namespace ninedot {
namespace {

/// As a calibration of some forty views knows a lens of this focal length.
IntrinsicCovariance usual_covariance(const CameraModel& camera) {
  IntrinsicCovariance covariance = IntrinsicCovariance::Zero();
  const double f = camera.fx_px / 500;
  covariance.diagonal() << 1e-4 * f * f, 1e-4 * f * f, 4e-3, 4e-3, 1e-6 * std::pow(f, 4), 1e-6 * std::pow(f, 8),
      1e-8 * f * f, 1e-8 * f * f, 1e-6 * std::pow(f, 12), 0, 0, 0;
  covariance(0, 1) = covariance(1, 0) = 0.9e-4 * f * f;
  return covariance;
}

ZoomLens exact_lens(int zoom, double wobble = 0.01, double phase = 0) {
  ZoomLens lens{zoom, test::zoom_lens(zoom, wobble, phase)};
  lens.covariance = usual_covariance(lens.camera);
  return lens;
}

std::vector<ZoomLens> exact_lenses(const std::vector<int>& zooms, double wobble = 0.01, double phase = 0) {
  std::vector<ZoomLens> lenses;
  for (const int zoom : zooms) lenses.push_back(exact_lens(zoom, wobble, phase));
  return lenses;
}

/// What pixels of the picture are off by, at most, when both look the same way. [px]
double largest_difference_px(const CameraModel& a, const CameraModel& b) {
  double largest = 0;
  for (double u = 0; u < a.width_px; u += 40)
    for (double v = 0; v < a.height_px; v += 40) {
      const auto ray = a.normalised_from_pixel({u, v});
      if (ray) largest = std::max(largest, (b.pixel_from_normalised(*ray) - Eigen::Vector2d(u, v)).norm());
    }
  return largest;
}

const std::vector<int> kEight{0, 250, 450, 600, 730, 840, 940, 1023};

TEST(ZoomTable, GivesEachPositionItsOwnLens) {
  for (const auto& zooms : {std::vector<int>{0, 512}, {0, 300, 1023}, kEight}) {
    const ZoomTable table(exact_lenses(zooms));
    for (const ZoomLens& own : table.lenses()) {
      const auto lens = table.at(own.zoom);
      ASSERT_TRUE(lens);
      EXPECT_EQ(lens->zoom, own.zoom);
      EXPECT_LT(largest_difference_px(own.camera, lens->camera), 1e-6);
      // Beside its own the half step to which a camera rounds, nothing.
      const CameraModel before = test::zoom_lens(own.zoom - 0.5), after = test::zoom_lens(own.zoom + 0.5);
      const double slope_px = after.fx_px - before.fx_px;
      if (table.knows_between()) {
        EXPECT_NEAR(lens->covariance(0, 0), own.covariance(0, 0) + slope_px * slope_px / 6, 0.03 * slope_px * slope_px);
      }
      EXPECT_GT(lens->covariance(0, 0), own.covariance(0, 0));
    }
  }
}

TEST(ZoomTable, ForetellsALensBetweenItsPositions) {
  const ZoomTable table(exact_lenses(kEight));
  double worst_share = 0, worst_px = 0;
  for (int zoom = 0; zoom <= test::kZoomEnd; zoom += 3) {
    const CameraModel truth = test::zoom_lens(zoom);
    const auto lens = table.at(zoom);
    ASSERT_TRUE(lens);
    worst_share = std::max(worst_share, std::abs(lens->camera.fx_px / truth.fx_px - 1));
    // Focal lengths apart: what distortion and centre are off by.
    CameraModel same_focus = lens->camera;
    same_focus.fx_px = truth.fx_px, same_focus.fy_px = truth.fy_px;
    worst_px = std::max(worst_px, largest_difference_px(truth, same_focus));
  }
  EXPECT_LT(worst_share, 0.0015);
  EXPECT_LT(worst_px, 0.5);
}

/// Lenses whose cams wobble, positions set at will: the errors made are those that are said. Counted in steps so fine
/// that their rounding hides nothing.
TEST(ZoomTable, IsHonestAboutWhatItForetells) {
  constexpr double kFine = 64;
  std::mt19937 random(20261123);
  std::uniform_real_distribution<double> part(0, 1);
  for (const int count : {6, 8, 11}) {
    double squares = 0, sum = 0;
    int looks = 0;
    for (int lens = 0; lens < 40; ++lens) {
      const double wobble = 0.003 * std::pow(10, part(random)), phase = 6.28 * part(random);
      std::vector<int> zooms{0};
      for (int i = 1; i < count; ++i)
        zooms.push_back(
            static_cast<int>(kFine * 1023 * (i + 0.5 * (part(random) - 0.5) * (i + 1 < count)) / (count - 1)));
      std::vector<ZoomLens> lenses;
      for (const int zoom : zooms) {
        lenses.push_back({zoom, test::zoom_lens(zoom / kFine, wobble, phase)});
        lenses.back().covariance = usual_covariance(lenses.back().camera);
      }
      const ZoomTable table(lenses);
      for (std::size_t gap = 0; gap + 1 < zooms.size(); ++gap) {
        const int zoom = (zooms[gap] + zooms[gap + 1]) / 2;
        const auto foretold = table.at(zoom);
        ASSERT_TRUE(foretold);
        const double off = (foretold->camera.fx_px - test::zoom_lens(zoom / kFine, wobble, phase).fx_px) /
                           std::sqrt(foretold->covariance(0, 0));
        squares += off * off, sum += std::abs(off) > 3, ++looks;
      }
    }
    const double rms = std::sqrt(squares / looks);
    EXPECT_LT(rms, 1.0) << count;
    EXPECT_GT(rms, 0.1) << count;
    EXPECT_LT(sum / looks, 0.02) << count;
  }
}

TEST(ZoomTable, CarriesTheCovariancesOfItsPositionsOver) {
  // A lens that the curve follows exactly, so that the calibrations' errors are all there is.
  const auto straight = [](int zoom) {
    ZoomLens lens{zoom, CameraModel{}};
    lens.camera.fx_px = lens.camera.fy_px = 500 * std::exp(0.00002 * zoom);
    lens.camera.k[0] = (-0.3 + 6e-6 * zoom) * std::pow(lens.camera.fx_px / 500, 2);
    lens.covariance = 1e4 * usual_covariance(lens.camera);
    lens.covariance(4, 4) *= 1e-8;  // what k1 is off by there comes from the focal length
    return lens;
  };
  std::vector<ZoomLens> exact;
  for (const int zoom : {0, 20000, 40000, 60000, 80000, 100000}) exact.push_back(straight(zoom));
  const auto said = ZoomTable(exact).at(93000);
  ASSERT_TRUE(said);
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  double squares_px2 = 0, squares_k1 = 0, product = 0;
  constexpr int kDraws = 1500;
  for (int draw = 0; draw < kDraws; ++draw) {
    std::vector<ZoomLens> drawn = exact;
    for (ZoomLens& lens : drawn) {
      const double common = normal(random) * std::sqrt(lens.covariance(0, 0));
      lens.camera.fx_px += common;
      lens.camera.k[0] += normal(random) * std::sqrt(lens.covariance(4, 4));
    }
    const auto off = ZoomTable(drawn).at(93000);
    const double focal = off->camera.fx_px - said->camera.fx_px, k1 = off->camera.k[0] - said->camera.k[0];
    squares_px2 += focal * focal / kDraws, squares_k1 += k1 * k1 / kDraws, product += focal * k1 / kDraws;
  }
  EXPECT_NEAR(squares_px2 / said->covariance(0, 0), 1, 0.15);
  EXPECT_NEAR(squares_k1 / said->covariance(4, 4), 1, 0.15);
  EXPECT_NEAR(product, said->covariance(0, 4), 0.1 * std::sqrt(squares_px2 * squares_k1));
}

TEST(ZoomTable, KnowsItsPositionsAloneWhereTheyAreFew) {
  const ZoomTable table(exact_lenses({100, 300, 500, 700}));
  EXPECT_FALSE(table.knows_between());
  EXPECT_EQ(table.reach(), "100, 300, 500 and 700 alone");
  for (const int zoom : {0, 99, 101, 299, 400, 1023}) EXPECT_FALSE(table.at(zoom)) << zoom;
  EXPECT_TRUE(table.at(300));
  const ZoomTable more(exact_lenses({100, 300, 500, 700, 900}));
  EXPECT_EQ(more.reach(), "100 to 900");
  for (const int zoom : {99, 901}) EXPECT_FALSE(more.at(zoom)) << zoom;
  for (const int zoom : {100, 101, 400, 900}) EXPECT_TRUE(more.at(zoom)) << zoom;
}

TEST(ZoomTable, KnowsItsWidestPositionWhicheverWayItCounts) {
  EXPECT_EQ(ZoomTable(exact_lenses({0, 500, 1023})).widest().zoom, 0);
  std::vector<ZoomLens> backwards = exact_lenses({0, 500, 1023});
  std::ranges::reverse(backwards);
  for (ZoomLens& lens : backwards) lens.zoom = 1023 - lens.zoom;
  EXPECT_EQ(ZoomTable(backwards).widest().zoom, 1023);
}

TEST(ZoomTable, NamesTheGapThatIsTooWide) {
  const ZoomTable table(exact_lenses({0, 150, 300, 800, 900, 1023}));
  const ZoomGap gap = table.worst_gap();
  EXPECT_EQ(gap.from, 300);
  EXPECT_EQ(gap.to, 800);
  EXPECT_EQ(gap.worst, 550);
  EXPECT_GT(gap.focal_sigma, 1.5 * ZoomTable(exact_lenses(kEight)).worst_gap().focal_sigma);
  EXPECT_FALSE(what_gaps_lack(table));
  // Cams that wobble more.
  EXPECT_EQ(
      what_gaps_lack(ZoomTable(exact_lenses({0, 150, 300, 800, 900, 1023}, 0.05))).value_or("nothing").substr(0, 52),
      "between 300 and 800 the focal length is foretold to ");
}

/// One recording under another's position.
TEST(ZoomTable, IsUncertainWhereOnePositionContradictsTheOthers) {
  std::vector<ZoomLens> lenses = exact_lenses(kEight);
  lenses[3].camera.fx_px *= 1.06, lenses[3].camera.fy_px *= 1.06;
  const ZoomTable table(lenses);
  EXPECT_GT(table.worst_gap().focal_sigma, 0.01);
  EXPECT_TRUE(what_gaps_lack(table));
  const auto off = [&](const HeldOutZoom& held_out) {
    return std::abs(
        std::log(held_out.foretold.fx_px / std::ranges::find(lenses, held_out.zoom, &ZoomLens::zoom)->camera.fx_px));
  };
  const std::vector<HeldOutZoom> all = table.held_out();
  ASSERT_EQ(all.size(), kEight.size() - 2);
  EXPECT_GT(off(all[2]), 0.04);
}

TEST(ZoomTable, FindsWhereItsCurveTurnsBack) {
  std::vector<ZoomLens> lenses = exact_lenses({0, 200, 400, 600, 800, 1000});
  EXPECT_FALSE(ZoomTable(lenses).turning_gap());
  double f = 500;
  for (std::size_t i = 0; i < lenses.size(); ++i, f *= i == 3 ? 3 : 1.001)
    lenses[i].camera.fx_px = lenses[i].camera.fy_px = f;
  const auto gap = ZoomTable(lenses).turning_gap();
  ASSERT_TRUE(gap);
  EXPECT_EQ(gap->to - gap->from, 200);
  EXPECT_NE(what_gaps_lack(ZoomTable(lenses)).value_or("").find(" the focal length would turn back: record one at "),
            std::string::npos);
}

TEST(ZoomTable, SaysWhatPositionsLack) {
  const auto lack = [](const std::vector<ZoomLens>& lenses) { return what_zooms_lack(lenses).value_or("nothing"); };
  EXPECT_EQ(lack(exact_lenses({0, 500})), "nothing");
  EXPECT_EQ(lack(exact_lenses({500})), "a zoom needs two positions at least");
  EXPECT_EQ(lack(exact_lenses({0, 500, 500, 700})), "position 500 is there twice");
  EXPECT_EQ(lack(std::vector<ZoomLens>(65)), "65 positions are too many; take 64 at most");
  std::vector<ZoomLens> lenses = exact_lenses({0, 300, 600});
  lenses[2].camera.width_px = 1280;
  EXPECT_EQ(lack(lenses), "position 600 has pictures of 1280x480 px, position 0 of 640x480");
  lenses = exact_lenses({0, 300, 600});
  lenses[1].camera.model = DistortionModel::kEquidistant;
  EXPECT_EQ(lack(lenses), "position 300 has another lens model than position 0");
  lenses = exact_lenses({0, 300, 600});
  std::swap(lenses[1].camera, lenses[2].camera);
  EXPECT_EQ(lack(lenses),
            "the focal length does not rise all along: 1486.6 px at position 300, 837.4 px at 600; are the positions "
            "right?");
  lenses = exact_lenses({0, 300, 600});
  lenses[2].camera = lenses[1].camera;
  EXPECT_EQ(lack(lenses), "the focal length is 837.4 px at both 300 and 600; are the positions right?");
}

}  // namespace
}  // namespace ninedot
