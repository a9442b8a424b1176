#include "mapping/start_places.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>

#include <algorithm>

#include "hall.h"
#include "mapping/adjustment.h"
#include "mapping/map_covariance.h"

namespace ninedot {
namespace {

class StartPlaces : public testing::Test {
 protected:
  StartPlaces() : hall_(test::make_hall(options())), network_(make_network(hall_.frames, hall_.known(1), exact_, {})) {}

  static test::HallOptions options() {
    test::HallOptions options;
    options.landmarks = 24;
    options.frames = 250;
    options.wrong_identities = 0.01;
    return options;
  }
  void place_all() {
    place_landmarks(network_, find_links(network_));
    place_frames(network_);
    drop_unconnected(network_);
  }
  double worst_m() const {
    double worst = 0;
    for (std::size_t i = 0; i < network_.landmarks.size(); ++i)
      worst = std::max(worst, step_between(network_.landmarks[i].place, hall_.truth[i].T_world_landmark).norm());
    return worst;
  }
  std::vector<std::size_t> sightings_of(std::size_t landmark) const {
    std::vector<std::size_t> list;
    for (std::size_t i = 0; i < network_.sightings.size(); ++i)
      if (network_.sightings[i].landmark == landmark) list.push_back(i);
    return list;
  }

  const std::vector<std::uint16_t> exact_{1};
  const test::Hall hall_;
  SightingNetwork network_;
};

TEST_F(StartPlaces, AreNearTheTruthWhateverMirrorImagesAndWrongIdentitiesThereAre) {
  place_all();
  EXPECT_TRUE(std::ranges::all_of(network_.landmarks, &NetworkLandmark::placed));
  EXPECT_LT(worst_m(), 0.15);
}

TEST_F(StartPlaces, OfFramesExplainWhatTheyShow) {
  place_all();
  std::size_t good = 0, all = 0;
  for (const NetworkSighting& sighting : network_.sightings) {
    if (!network_.counts(sighting)) continue;
    ++all;
    good += network_.chi2_of(sighting) < 1e5 ? 1U : 0U;  // within some ten pixels
  }
  EXPECT_GT(good, all * 97 / 100);
}

TEST_F(StartPlaces, ThatAreWrongAreFoundBesideTheOthers) {
  place_all();
  adjust(network_, {});
  const WorldFromLandmark truth = hall_.truth[7].T_world_landmark;
  network_.landmarks[7].place = {truth.rotation * exp_so3({0, 0, 0.8}),
                                 truth.translation_m + Eigen::Vector3d(0.3, 0, 0)};
  const std::optional<PlaceConsensus> found = place_among_others(network_, 7, sightings_of(7));
  ASSERT_TRUE(found);
  EXPECT_GT(4 * found->agreeing, 3 * found->pictures);
  EXPECT_LT(step_between(found->place, truth).norm(), 0.02);
}

TEST_F(StartPlaces, FarFromTheOptimumAreLedThereInAFewSteps) {
  test::HallOptions exactly = options();
  exactly.noise = exactly.wrong_identities = 0;
  const test::Hall hall = test::make_hall(exactly);
  network_ = make_network(hall.frames, hall.known(1), exact_, {});
  place_all();
  for (std::size_t i = 1; i < network_.landmarks.size(); ++i) {
    PlaceStep off;
    off << 0.05, -0.04, 0.03, 0.1, -0.2, 0.15;
    network_.landmarks[i].place = moved_by(network_.landmarks[i].place, (i % 2 == 0 ? 1 : -1) * off);
  }
  AdjustmentOptions options;
  options.max_iterations = 12;  // with a wrong derivative there would be hundreds
  options.tolerance = 1e9;
  adjust(network_, options);
  EXPECT_LT(worst_m(), 1e-5);
}

TEST_F(StartPlaces, CovariancesOfPairsAreThoseOfTheWholeInverse) {
  place_all();
  adjust(network_, {});
  // Asked in both orders, each from another column.
  const auto covariance = covariance_of(network_, {{2, 5}, {5, 2}});
  ASSERT_TRUE(covariance);
  EXPECT_TRUE(covariance->pairs[0].isApprox(covariance->pairs[1].transpose(), 1e-9));
  EXPECT_TRUE(covariance->places[0].isZero(0)) << "the origin's";
  Eigen::Matrix<double, 12, 12> both;
  both << covariance->places[2], covariance->pairs[0], covariance->pairs[1], covariance->places[5];
  EXPECT_GT((Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 12, 12>>(both).eigenvalues().minCoeff()), 0);
}

}  // namespace
}  // namespace ninedot
