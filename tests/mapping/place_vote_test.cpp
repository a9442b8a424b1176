#include "mapping/place_vote.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/random.h"

namespace ninedot {
namespace {

const WorldFromLandmark kPlace{exp_so3({0.1, 0.2, 2.0}), {1, -2, 1.5}};

PlaceStep noise(double size, test::Random& random) {
  PlaceStep step;
  for (double& part : step) part = size * random.normal();
  return step;
}

PlaceVote vote(std::size_t picture, const WorldFromLandmark& place, double sigma, double penalty = 0) {
  return {picture, place, sigma * sigma * PlaceCovariance::Identity(), penalty};
}

TEST(PlaceVote, StepsAreWhatLiesBetweenTwoPlaces) {
  test::Random random(1);
  const PlaceStep step = noise(0.3, random);
  EXPECT_LT((step_between(kPlace, moved_by(kPlace, step)) - step).norm(), 1e-12);
}

TEST(PlaceConsensus, IsThatOfTheMirrorImagesWhichStayInPlace) {
  test::Random random(2);
  std::vector<PlaceVote> votes;
  for (std::size_t picture = 0; picture < 10; ++picture) {
    // From every side the mirror image is another one; here it even seems the better one.
    const auto angle = 0.1 * static_cast<double>(picture);
    const WorldFromLandmark mirror{exp_so3({0.5 + angle, 0.3 - angle, 0}) * kPlace.rotation, kPlace.translation_m};
    votes.push_back(vote(picture, mirror, 0.01));
    votes.push_back(vote(picture, moved_by(kPlace, noise(0.01, random)), 0.01, 1.0));
  }
  const PlaceConsensus found = find_consensus(votes);
  EXPECT_EQ(found.agreeing, 10U);
  EXPECT_EQ(found.pictures, 10U);
  EXPECT_LT(step_between(found.place, kPlace).norm(), 0.02);
  EXPECT_NEAR(std::sqrt(found.covariance(0, 0)), 0.01 / std::sqrt(10), 1e-6);
  EXPECT_GT(found.lead_chi2, 100);
}

TEST(PlaceConsensus, SaysWhenOnePictureLeavesOpenWhichReadingIsRight) {
  const WorldFromLandmark mirror{exp_so3({0.5, 0, 0}) * kPlace.rotation, kPlace.translation_m};
  const PlaceConsensus found = find_consensus(std::vector{vote(7, kPlace, 0.01), vote(7, mirror, 0.01, 2.5)});
  EXPECT_LT(step_between(found.place, kPlace).norm(), 1e-9);
  EXPECT_NEAR(found.lead_chi2, 2.5, 1e-9);
}

TEST(PlaceConsensus, IsNotLedAstrayByAThirdOfWrongPictures) {
  test::Random random(3);
  std::vector<PlaceVote> votes;
  for (std::size_t picture = 0; picture < 30; ++picture)
    votes.push_back(vote(
        picture,
        picture % 3 == 0
            ? WorldFromLandmark{kPlace.rotation, kPlace.translation_m + Eigen::Vector3d(random.uniform(3, 9), 0, 0)}
            : moved_by(kPlace, noise(0.01, random)),
        0.01));
  const PlaceConsensus found = find_consensus(votes);
  EXPECT_LT(step_between(found.place, kPlace).norm(), 0.02);
  EXPECT_LT(found.agreeing, found.pictures);
  EXPECT_GE(3 * found.agreeing, 2 * found.pictures - 3);
}

TEST(PlaceConsensus, GivesAPoorPictureAsMuchWeightAsItDeserves) {
  std::vector<PlaceVote> votes{vote(0, kPlace, 0.001)};
  votes.push_back(vote(1, {kPlace.rotation, kPlace.translation_m + Eigen::Vector3d(0.1, 0, 0)}, 0.1));
  EXPECT_LT((find_consensus(votes).place.translation_m - kPlace.translation_m).norm(), 1e-4);
}

}  // namespace
}  // namespace ninedot
