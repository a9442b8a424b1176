#include "geometry/definite_inverse.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "tests/support/random.h"

namespace ninedot {
namespace {

TEST(DefiniteInverse, IsTheInverse) {
  test::Random random(7);
  for (int trial = 0; trial < 50; ++trial) {
    Eigen::Matrix<double, 11, 11> root;
    for (double& value : root.reshaped()) value = random.normal();
    // As an information matrix is: unknowns of very different units, and little known of some.
    Eigen::Matrix<double, 11, 1> unit;
    for (double& value : unit.reshaped()) value = std::pow(10, 2 * random.normal());
    const Eigen::Matrix<double, 11, 11> A = unit.asDiagonal() * (root * root.transpose()) * unit.asDiagonal();
    const Eigen::Matrix<double, 11, 11> in_own_units =
        unit.asDiagonal() * inverse_of_definite(A) * unit.asDiagonal() * (root * root.transpose());
    EXPECT_LT((in_own_units - in_own_units.Identity()).cwiseAbs().maxCoeff(), 1e-6);
    EXPECT_LT((inverse_of_definite(A) - A.inverse()).norm(), 1e-6 * A.inverse().norm());
  }
}

TEST(DefiniteInverse, OfWhatHasNoneIsNotTakenForOne) {
  EXPECT_FALSE(inverse_of_definite<3>(Eigen::Matrix3d::Zero()).allFinite());
}

}  // namespace
}  // namespace ninedot
