// The bound against numbers that were worked out independently of it, and against the renderer that it is a bound for.
#include "tests/bench/crlb.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <numbers>

#include "tests/support/renderer_optics.h"

namespace ninedot::bench {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

// Linear, paper 200 and ink 50 grey levels, noise 2, blur 0.6 px in all.
test::Scene plain_scene(double distance_m, double tilt_deg) {
  test::Scene scene;
  scene.camera = test::look_at_landmark({distance_m, tilt_deg * kDegree, 0, 0, 0, 0});
  scene.light.level = 1;
  scene.sheets[0].reflectance = 200 / 255.0;
  for (test::Disc& disc : scene.sheets[0].discs) disc.reflectance = 50 / 255.0;
  scene.sensor.tone = test::ToneCurve::kLinear;
  scene.sensor.point_spread_px = std::sqrt(0.36 - 1.0 / 12);
  scene.sensor.noise_b = (4 - 1.0 / 12) / (255 * 255);
  return scene;
}

// Computed by a separate program, in another language, with numerical derivatives.
TEST(CramerRaoBound, AgreesWithIndependentlyComputedValues) {
  const struct {
    double distance_m, tilt_deg, position_mm, along_mm, rotation_deg;
  } cases[] = {{0.6, 20, 0.0466, 0.0082, 0.00442},
               {1, 5, 0.4876, 0.0259, 0.02786},
               {1, 45, 0.0912, 0.0373, 0.00507},
               {3, 20, 2.7908, 0.4929, 0.05324}};
  for (const auto& c : cases) {
    const auto bound = cramer_rao_bound(plain_scene(c.distance_m, c.tilt_deg));
    ASSERT_TRUE(bound);
    const auto label = ::testing::Message() << c.distance_m << " m " << c.tilt_deg << " deg";
    EXPECT_NEAR(1000 * bound->position_m / c.position_mm, 1, 0.03) << label;
    EXPECT_NEAR(1000 * bound->along_m / c.along_mm, 1, 0.03) << label;
    EXPECT_NEAR(bound->rotation_rad / kDegree / c.rotation_deg, 1, 0.03) << label;
  }
}

// The same information, from differences of rendered pictures: the bound's model is the renderer's. The sub-samples
// make such differences rough by some per cent, and roughness counts as information: hence the tolerance.
TEST(CramerRaoBound, AgreesWithTheInformationInRenderedPictures) {
  test::Scene scene = plain_scene(0.9, 35);
  scene.lens.k = {-0.12, 0.05, 0.0008, -0.0005};
  scene.sensor.point_spread_px = 0.8;
  const auto exposed = [&](int unknown, double step) {
    test::Scene moved = scene;
    if (unknown < 3) moved.camera.position_m[static_cast<std::size_t>(unknown)] += step;
    if (unknown >= 3 && unknown < 6) {
      const auto& q = scene.camera.quaternion_wxyz;
      const Eigen::Vector3d turn = step * Eigen::Vector3d::Unit(unknown - 3);
      const Eigen::Quaterniond turned = Eigen::Quaterniond(q[0], q[1], q[2], q[3]) *
                                        Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
      moved.camera.quaternion_wxyz = {turned.w(), turned.x(), turned.y(), turned.z()};
    }
    if (unknown == 6) moved.sheets[0].reflectance += step;
    if (unknown == 7)
      for (test::Disc& disc : moved.sheets[0].discs) disc.reflectance += step;
    if (unknown == 8) moved.sensor.point_spread_px += step;
    moved.sheets[0].width_m = moved.sheets[0].height_m = 5;  // the sheet's border is not part of the model
    return test::expose(moved).light;
  };
  constexpr std::array<double, 9> kSteps = {2e-4, 2e-4, 2e-4, 2e-4, 2e-4, 2e-4, 0.01, 0.01, 0.02};
  Eigen::MatrixXd J(scene.lens.width_px * scene.lens.height_px, 9);
  for (int i = 0; i < 9; ++i) {
    const double step = kSteps[static_cast<std::size_t>(i)];
    const auto up = exposed(i, step), down = exposed(i, -step);
    for (Eigen::Index p = 0; p < J.rows(); ++p)
      J(p, i) = (up[static_cast<std::size_t>(p)] - down[static_cast<std::size_t>(p)]) / (2 * step);
  }
  const Eigen::MatrixXd covariance = (J.transpose() * J).inverse() * (scene.sensor.noise_b + 1.0 / 12 / (255 * 255));
  const auto bound = cramer_rao_bound(scene);
  ASSERT_TRUE(bound);
  for (Eigen::Index i = 0; i < 6; ++i) EXPECT_NEAR(std::sqrt(bound->covariance(i, i) / covariance(i, i)), 1, 0.1) << i;
}

TEST(CramerRaoBound, GrowsWhereTheBoardHidesAndWithNoise) {
  test::Scene scene = plain_scene(1, 30);
  const double open_m = cramer_rao_bound(scene)->position_m;
  scene.board.hidden_fraction = 0.4;
  EXPECT_GT(cramer_rao_bound(scene)->position_m, 1.2 * open_m);
  scene.board.hidden_fraction = 0;
  scene.sensor.noise_b = (16 - 1.0 / 12) / (255 * 255);
  EXPECT_NEAR(cramer_rao_bound(scene)->position_m, 2 * open_m, 1e-9);
}

TEST(CramerRaoBound, DoesNotExistWhereNothingIsVisible) {
  test::Scene scene = plain_scene(1, 30);
  scene.board.hidden_fraction = 1;
  EXPECT_FALSE(cramer_rao_bound(scene));
}

}  // namespace
}  // namespace ninedot::bench
