#include "world/place_uncertainty.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>

#include "tests/world/room.h"

namespace ninedot {
namespace {

using test::Random;

struct View {
  WorldFromCamera T_world_camera;
  WorldFromLandmark place;
  LandmarkSighting sighting;
};

View any_view(Random& random) {
  const test::Room room = test::random_room(random, {.landmarks = 1, .farthest_m = 3});
  const WorldFromLandmark& place = room.map[0].T_world_landmark;
  return {room.T_world_camera, place, test::sighting_of(random, room.T_world_camera, place).sighting};
}

PoseCovariance any_covariance(Random& random, double size) {
  PoseCovariance A;
  for (double& a : A.reshaped()) a = size * random.normal();
  return A * A.transpose();
}

TEST(PlaceUncertainty, AnErrorOfAPlaceIsAStepOfTheCamera) {
  Random random(31);
  for (int trial = 0; trial < 20; ++trial) {
    const View view = any_view(random);
    for (Eigen::Index i = 0; i < 6; ++i) {
      const PoseStep error = 1e-5 * PoseStep::Unit(i);
      WorldFromLandmark off = view.place;
      off.translation_m += error.head<3>();
      off.rotation = exp_so3(error.tail<3>()) * off.rotation;
      // B itself, from the covariance of an error in one direction alone: B e e^T B^T, whose column signs are lost.
      const PoseCovariance one = step_covariance_of_place(error * error.transpose(), view.place, view.T_world_camera);
      Eigen::Index largest = 0;
      one.diagonal().maxCoeff(&largest);
      PoseStep step = one.col(largest) / std::sqrt(one(largest, largest));
      const CameraFromLandmark seen = view.T_world_camera.inverse() * off;
      const auto distance = [&](const PoseStep& s) {
        const CameraFromLandmark T = moved_by(view.T_world_camera, s).inverse() * view.place;
        return (T.translation_m - seen.translation_m).norm() + (T.rotation - seen.rotation).norm();
      };
      EXPECT_LT(std::min(distance(step), distance(-step)), 1e-8) << i;
    }
  }
}

TEST(PlaceUncertainty, IsWhatIsLeftWhenTheLikeliestErrorIsTaken) {
  Random random(32);
  for (int trial = 0; trial < 20; ++trial) {
    const View view = any_view(random);
    const WorldFromCamera at = moved_by(view.T_world_camera, PoseStep::Constant(1e-3));
    const SightingFit fit = fit_of_sighting(view.sighting, view.place, at, {});
    const PoseCovariance C = any_covariance(random, 2e-3);
    const SightingFit soft = softened(fit, C);
    const PoseStep s = -(fit.normal + C.inverse()).ldlt().solve(fit.gradient);
    const double least = fit.chi2 + 2 * fit.gradient.dot(s) + s.dot(fit.normal * s) + s.dot(C.inverse() * s);
    EXPECT_NEAR(soft.chi2, least, 1e-6 * fit.chi2);
    EXPECT_LT((soft.normal - (fit.normal.inverse() + C).inverse()).norm(), 1e-6 * soft.normal.norm());
    EXPECT_LT((soft.gradient - (fit.gradient + fit.normal * s)).norm(), 1e-6 * fit.gradient.norm());
  }
}

TEST(PlaceUncertainty, OfATurnIsWhatItIsOfItsCovariance) {
  Random random(34);
  for (const double turn_sigma_rad : {1e-6, 1e-4, 1e-2, 1.0}) {
    const View view = any_view(random);
    const WorldFromCamera at = moved_by(view.T_world_camera, PoseStep::Constant(1e-3));
    const SightingFit fit = fit_of_sighting(view.sighting, view.place, at, {});
    const SightingFit soft = softened_by_turn(fit, turn_sigma_rad);
    const SightingFit expected = softened(fit, step_covariance_of_turn(turn_sigma_rad));
    EXPECT_NEAR(soft.chi2, expected.chi2, 1e-6 * fit.chi2) << turn_sigma_rad;
    EXPECT_EQ(soft.dots, expected.dots);
    EXPECT_LT((soft.normal - expected.normal).norm(), 1e-6 * expected.normal.norm()) << turn_sigma_rad;
    EXPECT_LT((soft.gradient - expected.gradient).norm(), 1e-6 * fit.gradient.norm()) << turn_sigma_rad;
    EXPECT_LT(soft.chi2, fit.chi2);
  }
}

TEST(PlaceUncertainty, OfNoneChangesNothing) {
  Random random(33);
  const View view = any_view(random);
  const SightingFit fit = fit_of_sighting(view.sighting, view.place, view.T_world_camera, {});
  const SightingFit same = softened(fit, PoseCovariance::Zero());
  EXPECT_EQ(same.chi2, fit.chi2);
  EXPECT_LT((same.normal - fit.normal).norm(), 1e-12 * fit.normal.norm());
}

}  // namespace
}  // namespace ninedot
