// A consumer that looks at `valid` alone is not handed what may be wrong.
#include <gtest/gtest.h>

#include <cmath>

#include "base/units.h"
#include "pipeline/localiser.h"
#include "pipeline/next_report.h"
#include "tests/detect/sharpened_spots.h"
#include "tests/support/process_picture.h"
#include "tests/support/renderer.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

/// One frame through a localiser that knows nothing.
struct Look {
  explicit Look(const test::Scene& scene, const LocaliserOptions& options = {}, std::uint64_t seed = 1)
      : picture(test::render(scene, seed)), unit(CameraModel{}, options) {
    frame.luma = picture.view();
    frame.set_exposure(MonoTime(1s));
    fix = unit.process(frame);
    report = next_report({}, frame, fix, {.now = MonoTime(1s)});
  }
  test::Picture picture;
  Localiser unit;
  Frame frame;
  Fix fix;
  Report report;
};

test::Scene scene_at(const test::Viewpoint& viewpoint, double noise_lsb = 1.5) {
  test::Scene scene;
  scene.camera = test::look_at_landmark(viewpoint);
  test::set_noise(scene.sensor, noise_lsb);
  return scene;
}

double distance_m(const ReportPose& pose, const test::CameraPose& truth) {
  return std::hypot(pose.position_m[0] - truth.position_m[0], pose.position_m[1] - truth.position_m[1],
                    pose.position_m[2] - truth.position_m[2]);
}

/// What a picture of lone dark pixels, sharpened, is taken for.
TEST(TrustFull, ASharpenedPictureOfLonePixelsIsNoLandmark) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    const auto pixels = test::sharpened_spots(seed);
    Localiser unit(CameraModel{}, {});
    Report report;
    test::process_picture(unit, {pixels.data(), 640, 480, 640}, MonoTime(1s), 1, report);
    EXPECT_FALSE(report.valid) << seed;
  }
}

class Trust : public testing::TestWithParam<Solver> {};

TEST_P(Trust, ALevelViewIsValidAndHasNoRival) {
  const Look look(scene_at({.distance_m = 1, .tilt_rad = 0.4, .roll_rad = 0.05}), {.seeker = {.solver = GetParam()}});
  EXPECT_TRUE(look.report.valid && look.report.found);
  EXPECT_LT(look.report.ambiguity, 1e-4);
}

/// An excluded mirror image may come back as the view changes: no followed frame takes the word of the one before.
TEST(TrustFull, EveryFollowedFrameLooksAtTheMirrorImage) {
  Look look(scene_at({.distance_m = 0.7, .tilt_rad = 0.6}));
  for (int i = 1; i <= 6; ++i) {
    look.frame.set_exposure(MonoTime(1s + i * 30ms));
    const Fix& fix = look.unit.process(look.frame);
    ASSERT_TRUE(fix.tracked && fix.landmarks.size() == 1) << i;
    EXPECT_TRUE(look.unit.last_observation()->from_pose) << "or nothing was followed, frame " << i;
    EXPECT_EQ(fix.landmarks[0].candidates.list.size(), 2U) << i;
  }
}

TEST_P(Trust, TheRivalStandsInTheWorldWhereTheMapHasItsLandmark) {
  MappedLandmark hung;
  hung.T_world_landmark.rotation = Eigen::AngleAxisd(0.7, Eigen::Vector3d::UnitZ()).toRotationMatrix();
  hung.T_world_landmark.translation_m = {3, -2, 1.5};
  const Look look(scene_at({.distance_m = 0.7, .tilt_rad = 0.3, .roll_rad = 22.5 * kRadPerDeg}),
                  {.seeker = {.solver = GetParam()}, .map = LandmarkMap({hung})});
  ASSERT_GT(look.report.rival.odds, 0.05);
  const auto vector = [](const ReportPose& pose) { return Eigen::Vector3d::Map(pose.position_m.data()); };
  const auto rotation = [](const ReportPose& pose) {
    const auto& q = pose.quaternion_wxyz;
    return Eigen::Quaterniond(q[0], q[1], q[2], q[3]);
  };
  const ReportRival& rival = look.report.rival;
  EXPECT_LT((hung.T_world_landmark * vector(rival.camera_in_landmark) - vector(rival.camera_in_world)).norm(), 1e-9);
  EXPECT_LT((Eigen::Quaterniond(hung.T_world_landmark.rotation) * rotation(rival.camera_in_landmark))
                .angularDistance(rotation(rival.camera_in_world)),
            1e-9);
}

TEST_P(Trust, ARollBetweenTwoNumberingsIsAmbiguousAndTheRivalIsTheOtherOne) {
  const test::Scene scene = scene_at({.distance_m = 0.7, .tilt_rad = 0.3, .roll_rad = 22.5 * kRadPerDeg});
  const Look look(scene, {.seeker = {.solver = GetParam()}});
  EXPECT_FALSE(look.report.valid);
  EXPECT_TRUE(look.report.found && look.report.ambiguous);
  EXPECT_EQ(look.report.reason, Reason::kAmbiguous);
  EXPECT_GT(look.report.ambiguity, 0.05);
  EXPECT_GT(look.report.rival.odds, 0.05);
  EXPECT_FALSE(look.report.has_pose) << "nothing that could be taken for a last valid pose";
  const Report shown = with_pose_of(look.report, look.frame, look.fix.main(), {});
  const double best_m = std::min(distance_m(shown.camera_in_landmark, scene.camera),
                                 distance_m(look.report.rival.camera_in_landmark, scene.camera));
  EXPECT_LT(best_m, 0.02) << "one of the two is right";
  LocaliserOptions told{.seeker = {.solver = GetParam()}};
  told.seeker.detector.upright.expected_roll_rad = 22.5 * kRadPerDeg;
  const Look right(scene, told), other(scene, [&] {
    told.seeker.detector.upright.expected_roll_rad *= -1;
    return told;
  }());
  EXPECT_NE(right.report.valid && distance_m(right.report.camera_in_landmark, scene.camera) < 0.02,
            other.report.valid && distance_m(other.report.camera_in_landmark, scene.camera) < 0.02)
      << "one who knows the roll is told which";
}

TEST(TrustFull, WhatIsKnownTooRoughlyIsFoundAndNotValid) {
  const Look look(scene_at({.distance_m = 6, .tilt_rad = 0.5}, 11));
  ASSERT_TRUE(look.report.found);
  EXPECT_FALSE(look.report.valid);
  EXPECT_TRUE(look.report.reason == Reason::kUncertain || look.report.reason == Reason::kAmbiguous)
      << static_cast<int>(look.report.reason);
  const test::Scene near = scene_at({.distance_m = 2, .tilt_rad = 0.4}, 2);
  EXPECT_TRUE(Look(near).report.valid);
  const Look strict(near, {.trust = {.max_sigma_share = 1e-4}});
  EXPECT_EQ(strict.report.reason, Reason::kUncertain);
}

/// Prints that resemble the landmark. Each was a valid pose while a fit was judged by its own residuals.
TEST(TrustFull, APrintThatOnlyResemblesTheLandmarkIsNotValid) {
  const auto is_valid = [](const test::Sheet& sheet, double view_m) {
    test::Scene scene = scene_at({.distance_m = view_m, .tilt_rad = 0.35, .azimuth_rad = 0.4});
    scene.sheets = {sheet};
    return Look(scene).report.valid;
  };
  for (const double view_m : {0.8, 1.5, 2.5}) {
    EXPECT_TRUE(is_valid(test::nine_dot_sheet(), view_m)) << view_m;
    test::Sheet moved = test::nine_dot_sheet();
    moved.discs[2].x_m += 0.02;
    moved.discs[2].z_m += 0.02;
    EXPECT_FALSE(is_valid(moved, view_m)) << "one dot moved, " << view_m;
    EXPECT_FALSE(is_valid(test::nine_dot_sheet(0.080 * 0.72), view_m)) << "a ring of 0.72 of the size, " << view_m;
    test::Sheet alternate = test::nine_dot_sheet();
    alternate.discs.erase(alternate.discs.begin() + 4);
    alternate.discs.erase(alternate.discs.begin() + 1);
    EXPECT_FALSE(is_valid(alternate, view_m)) << "two dots missing, " << view_m;
    test::Sheet aside = test::nine_dot_sheet();
    aside.discs[8].x_m += 0.016;
    EXPECT_FALSE(is_valid(aside, view_m)) << "P9 aside, " << view_m;
  }
}

INSTANTIATE_TEST_SUITE_P(Localiser, Trust, testing::Values(Solver::kFull, Solver::kEllipse),
                         [](const auto& solver) { return solver.param == Solver::kFull ? "full" : "ellipse"; });

}  // namespace
}  // namespace ninedot
