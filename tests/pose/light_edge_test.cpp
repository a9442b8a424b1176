#include "pose/light_edge.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "tests/support/random.h"
#include "tests/support/rendered_truth.h"

namespace ninedot {
namespace {

double phi(double x) { return 0.5 * std::erfc(-x / std::numbers::sqrt2); }

/// A dot of 6 px radius, blurred by a pixel, and the light on it.
struct Dot {
  static constexpr double kRadius_px = 6, kNoise_lsb = 2;

  /// \param luma  grey level of (ink share, x, y)
  template <typename Luma>
  explicit Dot(Luma&& luma) {
    test::Random random(7);
    for (int row = -9; row <= 9; ++row)
      for (int column = -9; column <= 9; ++column) {
        const double radius_px = std::hypot(column, row), outside = radius_px - kRadius_px;
        if (radius_px > 9) continue;
        x.push_back(static_cast<float>(100 + column)), y.push_back(static_cast<float>(50 + row));
        ink.push_back(static_cast<float>(phi(-outside)));
        grey.push_back(static_cast<float>(luma(phi(-outside), column, row) + kNoise_lsb * random.normal()));
        distance.push_back(static_cast<float>(outside));
        const double per = radius_px > 0 ? 1 / radius_px : 0;
        out_x.push_back(static_cast<float>(column * per)), out_y.push_back(static_cast<float>(row * per));
      }
  }
  std::optional<LightEdge> edge() const {
    return find_light_edge({x, y, grey, ink, distance, out_x, out_y, 0.3}, nullptr);
  }

  std::vector<float> x, y, grey, ink, distance, out_x, out_y;
};

TEST(LightEdge, IsFoundToAFifthOfAPixelWhereverItCrosses) {
  for (const double angle_rad : {0.3, 1.8, 3.0, 4.5})
    for (const double place_px : {-4.0, -1.0, 0.0, 2.5}) {
      const double nx = std::cos(angle_rad), ny = std::sin(angle_rad);
      const Dot dot([&](double ink, double x, double y) {
        const double light = phi((nx * x + ny * y - place_px) / 0.8);
        return (1 - ink) * (120 + 90 * light) + ink * (20 + 27 * light);
      });
      const auto edge = dot.edge();
      ASSERT_TRUE(edge) << angle_rad << ", " << place_px;
      // It may look along its normal or against it.
      const double same = edge->normal.dot(Eigen::Vector2d(nx, ny)) > 0 ? 1 : -1;
      EXPECT_NEAR(same * (edge->offset_px - edge->normal.dot(Eigen::Vector2d(100, 50))), place_px, 0.2) << angle_rad;
      EXPECT_NEAR(std::abs(edge->normal.dot(Eigen::Vector2d(nx, ny))), 1, 0.005) << angle_rad << ", " << place_px;
      EXPECT_NEAR(edge->width_px, 0.8, 0.35) << angle_rad << ", " << place_px;
      EXPECT_NEAR(edge->paper_lsb, same * 90, 5) << angle_rad << ", " << place_px;
    }
}

TEST(LightEdge, ABoardThatHidesHalfOfADotIsNone) {
  const Dot dot([](double ink, double x, double /*y*/) {
    const double board = phi((x - 1) / 0.8);
    return (1 - board) * ((1 - ink) * 210 + ink * 40) + board * 90;
  });
  EXPECT_FALSE(dot.edge());
}

TEST(LightEdge, AnEdgeBesideTheDotIsNone) {
  const Dot dot([](double ink, double x, double y) {
    return (1 - ink) * 210 + ink * 40 + 30 * std::exp(-((x - 9) * (x - 9) + y * y) / 2);
  });
  const auto edge = dot.edge();
  if (edge) {
    EXPECT_LT(std::abs(edge->offset_px - edge->normal.dot(Eigen::Vector2d(100, 50))), 1.1 * 9);
  }
}

/// Of two independent steps that lie about in the same direction, blurred together.
TEST(LightEdge, InkBeyondItIsTheBivariateNormalDistribution) {
  for (const double r : {-0.6, -0.3, 0.3, 0.6})
    for (const double u : {-1.0, 0.0, 0.7})
      for (const double v : {-0.5, 0.4, 1.2}) {
        // P(a < u, b < v) of correlation r, by the definition: a's density times what is left of b.
        double both = 0;
        constexpr double kStep = 1e-3;
        for (double a = -7; a < u; a += kStep)
          both +=
              kStep * std::exp(-a * a / 2) / std::sqrt(2 * std::numbers::pi) * phi((v - r * a) / std::sqrt(1 - r * r));
        const double densities = std::exp(-(u * u + v * v) / 2) / (2 * std::numbers::pi);
        EXPECT_NEAR(ink_beyond(phi(u), phi(v), u, -v, densities, -r), both, 0.006) << r << ", " << u << ", " << v;
      }
}

}  // namespace
}  // namespace ninedot
