// What the mirror image of a landmark costs that a map and a track have told from it.
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <cstdint>
#include <optional>

#include "detect/detector.h"
#include "pose/full_solver.h"
#include "pose/mirror_image.h"
#include "pose/pose_of_outlines.h"
#include "tests/pose/first_fit.h"

namespace ninedot {
namespace {

constexpr FullSolverOptions kInRooms{.most_sigma = 1, .pattern_px = 0.1};

/// A landmark that was seen in the frame before.
class Followed {
 public:
  explicit Followed(const test::Viewpoint& viewpoint, double hidden_fraction = 0,
                    const FullSolverOptions& options = kInRooms)
      : solver_(CameraModel{}, LandmarkGeometry{}, options), scene_(test::scene_of(test::nine_dot_sheet(), viewpoint)) {
    scene_.board.hidden_fraction = hidden_fraction;
    first_ = test::first_fit(picture(1).view());
  }

  bool was_seen() const { return first_.has_value(); }
  /// \param expected  where it is looked for \param before  where the track had it \param is_settled  on which side
  Result<PoseCandidates> follow(const CameraFromLandmark& expected, const CameraFromLandmark& before, bool is_settled) {
    const test::Picture next = picture(2);
    int left = WorkBudget{}.pixels;
    auto answer =
        solver_.follow(next.view(), {expected, std::nullopt}, {before, first_->outlines, 0, is_settled}, left);
    pixels = WorkBudget{}.pixels - left;
    return answer;
  }
  CameraFromLandmark pose() const { return first_->pose.T_landmark_camera.inverse(); }
  CameraFromLandmark mirrored() const { return mirror_image(pose(), LandmarkGeometry{}); }

  int pixels = 0;  ///< that the last one looked at

 private:
  test::Picture picture(std::uint64_t seed) const { return test::render(scene_, seed); }

  FullSolver solver_;
  test::Scene scene_;
  std::optional<PoseCandidate> first_;
};

/// Both of its readings were fitted to the picture: where one is of the other's places, it has the other's residual.
bool are_of_the_picture(const PoseCandidates& found) {
  return found.list.size() == 2 && found.list[0].pose.rms_px != found.list[1].pose.rms_px;
}

/// After a first step whose weights are out of date the second one's are foretold, by equations.
TEST(FollowInRooms, AStepOfATenthOfAPixelTakesNoThirdLookAtThePicture) {
  int trials = 0, third_looks = 0;
  for (double distance_m = 2.5; distance_m < 5; distance_m += 0.25) {
    Followed landmark({.distance_m = distance_m, .tilt_rad = 0.5, .azimuth_rad = distance_m});
    ASSERT_TRUE(landmark.was_seen()) << distance_m;
    CameraFromLandmark aside = landmark.pose();
    aside.translation_m.x() += 0.1 * distance_m / CameraModel{}.fx_px;
    const auto from_aside = landmark.follow(aside, aside, true);
    const int pixels = landmark.pixels;
    const auto at_once = landmark.follow(landmark.pose(), landmark.pose(), true);  // one look
    ASSERT_TRUE(from_aside.has_value() && at_once.has_value()) << distance_m;
    const PoseEstimate &a = from_aside->list[0].pose, &b = at_once->list[0].pose;
    const Eigen::Vector3d apart_m = a.T_landmark_camera.translation_m - b.T_landmark_camera.translation_m;
    EXPECT_LT(std::sqrt(apart_m.dot(b.covariance.topLeftCorner<3, 3>().inverse() * apart_m)), 0.3) << distance_m;
    ++trials;
    third_looks += pixels > 2.4 * landmark.pixels ? 1 : 0;
  }
  EXPECT_LE(third_looks, trials / 3);
}

TEST(FollowInRooms, WhereTheSideIsSettledTheMirrorImageTakesNoPixels) {
  for (const double distance_m : {4.0, 5.0, 6.0}) {
    Followed landmark({.distance_m = distance_m, .tilt_rad = 0.5, .azimuth_rad = distance_m});
    ASSERT_TRUE(landmark.was_seen()) << distance_m;
    const auto by_picture = landmark.follow(landmark.pose(), landmark.pose(), false);
    const int with_mirror = landmark.pixels;
    const auto by_places = landmark.follow(landmark.pose(), landmark.pose(), true);
    ASSERT_TRUE(by_picture && by_places) << distance_m;
    EXPECT_LT(landmark.pixels, 0.7 * with_mirror) << distance_m;
    EXPECT_TRUE(are_of_the_picture(*by_picture)) << distance_m;
    ASSERT_EQ(by_places->list.size(), 2U) << distance_m;
    EXPECT_TRUE(by_places->list[1].refined);
    // The two say the same of it.
    const auto mirror = [](const PoseCandidates& found) { return found.list[1].pose.T_landmark_camera.inverse(); };
    EXPECT_LT(angle_between_rad(mirror(*by_places), mirror(*by_picture)), 0.1) << distance_m;
    EXPECT_NEAR(by_places->list[1].chi2_above / by_picture->list[1].chi2_above, 1, 0.5) << distance_m;
  }
}

TEST(FollowInRooms, ASideThatThePlacesContradictIsAskedOfThePicture) {
  Followed landmark({.distance_m = 3, .tilt_rad = 0.5, .azimuth_rad = 1});
  ASSERT_TRUE(landmark.was_seen());
  const auto followed = landmark.follow(landmark.mirrored(), landmark.mirrored(), true);
  ASSERT_TRUE(followed);
  EXPECT_TRUE(are_of_the_picture(*followed));
  EXPECT_LT(angle_between_rad(followed->list[0].pose.T_landmark_camera.inverse(), landmark.pose()), 0.1);
}

TEST(FollowInRooms, APoseThatHasLeftItsSideIsAskedOfThePicture) {
  Followed landmark({.distance_m = 5, .tilt_rad = 0.5, .azimuth_rad = 1});
  ASSERT_TRUE(landmark.was_seen());
  const auto followed = landmark.follow(landmark.pose(), landmark.mirrored(), true);
  ASSERT_TRUE(followed);
  EXPECT_TRUE(are_of_the_picture(*followed));
}

TEST(FollowInRooms, OfFewDotsThePictureIsAsked) {
  Followed landmark({.distance_m = 3, .tilt_rad = 0.5, .azimuth_rad = 1}, 0.3);
  ASSERT_TRUE(landmark.was_seen());
  const auto followed = landmark.follow(landmark.pose(), landmark.pose(), true);
  ASSERT_TRUE(followed);
  ASSERT_LE(followed->list[0].pose.dots_used, kFewDots);
  EXPECT_TRUE(are_of_the_picture(*followed));
}

// There the dots' places may show one pose where the outlines have two.
TEST(FollowInRooms, NearlyFromInFrontThePictureIsAskedUntilTheSideIsSettled) {
  for (const double tilt_rad : {0.0, 0.02, 0.05}) {
    Followed landmark({.distance_m = 3, .tilt_rad = tilt_rad, .azimuth_rad = 1});
    ASSERT_TRUE(landmark.was_seen());
    ASSERT_TRUE(landmark.follow(landmark.pose(), landmark.pose(), true)) << tilt_rad;
    const int without_mirror = landmark.pixels;
    ASSERT_TRUE(landmark.follow(landmark.pose(), landmark.pose(), false)) << tilt_rad;
    EXPECT_GT(landmark.pixels, 1.3 * without_mirror) << tilt_rad;
  }
}

TEST(FollowInRooms, WithoutAMapThePictureIsAsked) {
  Followed landmark({.distance_m = 5, .tilt_rad = 0.5, .azimuth_rad = 1}, 0, {});
  ASSERT_TRUE(landmark.was_seen());
  const auto followed = landmark.follow(landmark.pose(), landmark.pose(), true);
  ASSERT_TRUE(followed);
  EXPECT_TRUE(are_of_the_picture(*followed));
}

}  // namespace
}  // namespace ninedot
