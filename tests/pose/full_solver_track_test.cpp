#include <gtest/gtest.h>

#include <cmath>
#include <optional>

#include "pose/full_solver.h"
#include "tests/pose/solver_scene.h"

namespace ninedot {
namespace {

using test::errors_of;
using test::kDegree;
using test::pose_of;
using test::scene_at;

/// What a track hands to a solver after one picture.
struct OnePicture {
  explicit OnePicture(const test::Scene& scene) {
    Detector detector(CameraModel{}, LandmarkGeometry{});
    const test::Picture picture = test::render(scene, 1);
    const auto found = detector.find_landmarks(picture.view());
    if (!found) return;
    int pixels = WorkBudget{}.pixels;
    const auto candidates = solver.solve(picture.view(), found->front(), nullptr, pixels);
    if (!candidates) return;
    const PoseCandidate& best = candidates->list[0];
    prior = PosePrior{best.pose.T_landmark_camera.inverse(), best.outlines, candidates->warp_px, true};
    pose = best.pose;
  }
  /// \param as_before  what is not like the first picture's pose is not followed
  Result<PoseCandidates> follow(const test::Scene& scene, std::uint64_t seed, bool as_before = true) {
    const test::Picture picture = test::render(scene, seed);
    pixels_left = WorkBudget{}.pixels;
    return solver.follow(picture.view(), {prior->T_camera_landmark, as_before ? pose : std::nullopt}, *prior,
                         pixels_left);
  }
  FullSolver solver{CameraModel{}, LandmarkGeometry{}};
  std::optional<PosePrior> prior;
  std::optional<PoseEstimate> pose;
  int pixels_left = 0;  ///< of the last follow()
};

TEST(FullSolverTrack, FindsThePoseOfASolverThatWasToldWhereToLook) {
  for (const double distance_m : {1.5, 3.0, 5.0}) {
    for (const double moved_px : {0.0, 0.5, 1.0}) {
      test::Viewpoint viewpoint{.distance_m = distance_m, .tilt_rad = 0.5, .azimuth_rad = distance_m};
      OnePicture before(scene_at(viewpoint));
      ASSERT_TRUE(before.prior.has_value()) << distance_m;
      viewpoint.off_axis_x_rad = moved_px / 720;
      const test::Scene next = scene_at(viewpoint);
      const auto candidates = before.follow(next, 2);
      const auto followed = test::best_pose(candidates);
      ASSERT_TRUE(followed.has_value()) << distance_m << " m, " << moved_px << " px";
      const auto solved = pose_of(test::render(next, 2));
      ASSERT_TRUE(solved.has_value());
      const Vector6d difference = errors_of(next, *followed).pose - errors_of(next, *solved).pose;
      EXPECT_LT(std::sqrt(difference.dot(solved->covariance.inverse() * difference)), 1.0)
          << distance_m << " m, " << moved_px << " px";
      EXPECT_EQ(followed->dots_used, 9);
    }
  }
}

TEST(FullSolverTrack, FollowsWhereTheMirrorImageIsWithinTheUncertainty) {
  const test::Scene scene = scene_at({.distance_m = 3.5, .tilt_rad = 0.5 * kDegree});
  OnePicture before(scene);
  ASSERT_TRUE(before.prior.has_value());
  int followed = 0;
  for (std::uint64_t seed = 2; seed < 10; ++seed) followed += before.follow(scene, seed).has_value();
  EXPECT_GE(followed, 6) << "of 8; the others are ambiguous";
}

TEST(FullSolverTrack, AsksForADetectorWhenTheLandmarkIsNotQuiteThere) {
  const test::Viewpoint viewpoint{.distance_m = 2.5, .tilt_rad = 0.5};
  test::Viewpoint jumped = viewpoint;
  jumped.off_axis_x_rad = 6.0 / 720;
  test::Scene gone = scene_at(viewpoint);
  gone.sheets.clear();
  int which = 0;
  for (const test::Scene& next : {scene_at(jumped), gone}) {
    SCOPED_TRACE(++which);
    OnePicture before(scene_at(viewpoint));
    ASSERT_TRUE(before.prior.has_value());
    const auto followed = before.follow(next, 2);
    EXPECT_FALSE(followed.has_value());
    if (!followed) {
      EXPECT_EQ(followed.error().code, Errc::kNoLandmark);
    }
  }
}

TEST(FullSolverTrack, LeavesASearchItsPixelsWhereTheSheetHasTurned) {
  constexpr int kOfASearch = 8000;
  for (const double azimuth_rad : {1.3, 3.9, 5.2}) {
    const test::Viewpoint viewpoint{.distance_m = 1.5, .tilt_rad = 1.1, .azimuth_rad = azimuth_rad};
    OnePicture before(scene_at(viewpoint));
    ASSERT_TRUE(before.prior.has_value());
    test::Viewpoint turned = viewpoint;
    turned.azimuth_rad += 2.1;
    EXPECT_FALSE(before.follow(scene_at(turned), 2).has_value()) << azimuth_rad;
    EXPECT_GT(before.pixels_left, kOfASearch) << azimuth_rad;
  }
}

TEST(FullSolverTrack, FollowsWhereAShadowHasJustFallen) {
  const test::Viewpoint viewpoint{.distance_m = 2.5, .tilt_rad = 0.5};
  OnePicture before(scene_at(viewpoint));
  ASSERT_TRUE(before.prior.has_value());
  for (const double offset_m : {-0.05, 0.0, 0.05}) {
    test::Scene shaded = scene_at(viewpoint);
    shaded.light.shadows.push_back({.direction_rad = 0.4, .offset_m = offset_m, .width_m = 0.1, .remaining = 0.4});
    const auto followed = test::best_pose(before.follow(shaded, 2, false));
    ASSERT_TRUE(followed.has_value()) << offset_m;
    const Vector6d error = errors_of(shaded, *followed).pose;
    EXPECT_LT(std::sqrt(error.dot(followed->covariance.inverse() * error)), 4.5) << offset_m;  // 0.2 % of six freedoms
  }
}

/// In poor light, and so near that its outlines take half of the pixels that there are.
test::Scene near_in_poor_light() {
  test::Scene scene = scene_at({.distance_m = 0.9, .tilt_rad = 20 * kDegree}, 8);
  scene.light.level = 0.2;
  return scene;
}

TEST(FullSolverTrack, LeavesASearchItsPixelsWhereThereIsNothingButNoise) {
  const test::Scene scene = near_in_poor_light();
  OnePicture before(scene);
  ASSERT_TRUE(before.prior.has_value());
  test::Scene gone = scene;
  gone.sheets.clear();
  gone.wall.contrast = 0;
  int at_once = 0;
  for (std::uint64_t seed = 2; seed < 22; ++seed) {
    EXPECT_FALSE(before.follow(gone, seed, false).has_value()) << seed;
    EXPECT_GT(before.pixels_left, 0.5 * WorkBudget{}.pixels) << seed;
    if (before.pixels_left > 0.85 * WorkBudget{}.pixels) ++at_once;  // a look takes 9 %
  }
  EXPECT_GE(at_once, 17);  // some noise looks a bit like ink
}

TEST(FullSolverTrack, LeavesASearchItsPixelsWhereSomethingHasComeBeforeTheSheet) {
  const test::Scene scene = near_in_poor_light();
  OnePicture before(scene);
  ASSERT_TRUE(before.prior.has_value());
  for (const double direction_deg : {10.0, 100.0, 190.0, 280.0}) {
    test::Scene hidden = scene;
    hidden.board.hidden_fraction = 0.25;
    hidden.board.direction_rad = direction_deg * kDegree;
    EXPECT_FALSE(before.follow(hidden, 2).has_value()) << direction_deg;
    EXPECT_GT(before.pixels_left, 0.4 * WorkBudget{}.pixels) << direction_deg;
  }
}

}  // namespace
}  // namespace ninedot
