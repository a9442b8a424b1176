// Where a landmark will be seen, against many draws of the camera's place.
#include "world/foretold_ring.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "tests/support/random.h"
#include "world/landmark_map.h"

namespace ninedot {
namespace {

const LandmarkGeometry kLandmark{};
const WorldFromLandmark kPlace = place_upright({0.4, 5.0, 1.2}, 0.3);
const PoseCovariance kExact = PoseCovariance::Zero();

/// At the world's origin, looking along +y, Z up.
WorldFromCamera camera() {
  WorldFromCamera T;
  T.rotation << 1, 0, 0, 0, 0, 1, 0, -1, 0;
  return T;
}

PoseCovariance wide() {
  PoseCovariance L = PoseCovariance::Zero();
  for (int row = 0; row < 6; ++row)
    for (int col = 0; col <= row; ++col) L(row, col) = 0.01 * std::sin(1 + 3 * row + 7 * col);
  return L * L.transpose();
}

/// Root mean square over draws, of the dot and the direction where it is largest.
double drawn_ray_sigma(const PoseCovariance& covariance) {
  const PoseCovariance L = covariance.llt().matrixL();
  std::array<Eigen::Matrix2d, kRingDotCount> squares;
  squares.fill(Eigen::Matrix2d::Zero());
  const auto ray = [](const WorldFromCamera& T, std::size_t dot) -> Eigen::Vector2d {
    const Eigen::Vector2d C = kLandmark.centre_m(dot);
    return (T.inverse() * (kPlace * Eigen::Vector3d(C.x(), 0, C.y()))).hnormalized();
  };
  test::Random random(5);
  constexpr int kDraws = 20000;
  for (int draw = 0; draw < kDraws; ++draw) {
    PoseStep step;
    for (double& s : step) s = random.normal();
    const WorldFromCamera moved = moved_by(camera(), PoseStep(L * step));
    for (std::size_t dot = 0; dot < kRingDotCount; ++dot) {
      const Eigen::Vector2d d = ray(moved, dot) - ray(camera(), dot);
      squares[dot] += d * d.transpose() / kDraws;
    }
  }
  double largest = 0;
  for (const Eigen::Matrix2d& S : squares)
    for (double a_rad = 0; a_rad < 3.15; a_rad += 0.01) {
      const Eigen::Vector2d u(std::cos(a_rad), std::sin(a_rad));
      largest = std::max(largest, u.dot(S * u));
    }
  return std::sqrt(largest);
}

TEST(ForetoldRing, ScattersAsDrawsOfTheCamerasPlaceDo) {
  const double sigma = foretold_ray_sigma(camera(), wide(), kPlace, kExact, kLandmark);
  EXPECT_NEAR(sigma / drawn_ray_sigma(wide()), 1, 0.03);
}

/// A pose that does not know a landmark's tilt has the camera anywhere on a circle about it: there it is seen all the
/// same.
TEST(ForetoldRing, IsWhereItIsHoweverTheCameraGoesRoundIt) {
  PoseCovariance round = PoseCovariance::Zero();
  const WorldFromCamera T = camera();
  const Eigen::Vector3d arm_m = T.translation_m - kPlace.translation_m;
  for (const Eigen::Vector3d& axis : {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 0, 1)}) {
    PoseStep step;
    step << axis.cross(arm_m), T.rotation.transpose() * axis;
    round += 0.2 * 0.2 * step * step.transpose();
  }
  EXPECT_GT(std::sqrt(round.topLeftCorner<3, 3>().trace()), 1) << "metres";
  EXPECT_LT(foretold_ray_sigma(T, round, kPlace, kExact, kLandmark), 0.004) << "a quarter of its ring";
}

TEST(ForetoldRing, CountsWhatTheMapDoesNotKnow) {
  PoseCovariance place = PoseCovariance::Zero();
  place(0, 0) = 0.05 * 0.05;
  EXPECT_NEAR(foretold_ray_sigma(camera(), kExact, kPlace, place, kLandmark), 0.05 / 5.0, 0.0005);
}

TEST(ForetoldRing, IsNowhereBehindTheCamera) {
  const WorldFromLandmark behind = place_upright({0, -3, 0}, 0);
  EXPECT_EQ(foretold_ray_sigma(camera(), wide(), behind, kExact, kLandmark), std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace ninedot
