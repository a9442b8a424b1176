#include "pipeline/picture_row_time.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/world/room.h"

namespace ninedot {
namespace {

using test::Random;

/// A landmark each in the upper and in the lower part of a picture, before a camera that turns.
struct TwoSheets {
  explicit TwoSheets(std::uint64_t seed) : random(seed) {
    camera.rotation = test::level_camera(0.3, 0, 0);
    places = {test::sheet_at(camera, {-0.1, -0.3}, 1.6, 0.5), test::sheet_at(camera, {0.15, 0.3}, 1.9, -0.4)};
    tracked.motion = {camera, Eigen::Vector3d::Zero(), kTurning_rad_s};
    for (const WorldFromLandmark& place : places)
      sightings.push_back(test::sighting_of(random, camera, place).sighting);
  }

  SheetMotion motion_of(std::size_t i) const {
    return {-kTurning_rad_s, -kTurning_rad_s.cross(sightings[i].T_camera_landmark.translation_m), 0,
            0.5 * (test::camera_of_rooms().height_px - 1)};
  }

  /// The dots as a shutter of this row time shows them, and the pose that fits them best.
  void roll(double row_time_s) {
    for (std::size_t i = 0; i < sightings.size(); ++i) {
      const SheetMotion motion = motion_of(i);
      const CameraFromLandmark T = sightings[i].T_camera_landmark;
      for (std::size_t dot = 0; dot < kDotCount; ++dot) {
        const Eigen::Vector2d C = LandmarkGeometry{}.centre_m(dot);
        Eigen::Vector2d& ray = sightings[i].dots[dot].ray;
        ray += (test::camera_of_rooms().pixel_from_normalised(ray).y() - motion.middle_row_px) * row_time_s *
               motion.ray_velocity(T * Eigen::Vector3d(C.x(), 0, C.y()), T.translation_m);
      }
      const JointMember alone{&sightings[i], {}, nullptr};
      const auto T_landmark_camera = T.inverse();
      JointFit fit;
      fit_jointly({&alone, 1}, {T_landmark_camera.rotation, T_landmark_camera.translation_m}, {}, fit);
      const auto best = fit.T_world_camera.inverse();
      sightings[i].T_camera_landmark = {best.rotation, best.translation_m};
    }
  }

  /// The camera placed by the first one alone, as where the world solver leaves the other one out.
  std::optional<RowTimeEvidence> evidence(bool second_is_used, bool place_is_valid) const {
    const CameraModel model = test::camera_of_rooms();
    const LandmarkGeometry landmark;
    PictureRowTime picture(&tracked, landmark, model);
    for (std::size_t i = 0; i < sightings.size(); ++i)
      picture.add(sightings[i], motion_of(i), places[i], nullptr, i == 0 || second_is_used);
    return picture.evidence(place_is_valid ? std::optional(camera) : std::nullopt);
  }

  inline static const Eigen::Vector3d kTurning_rad_s{0.1, 0.7, 0};
  Random random;
  WorldFromCamera camera;
  std::vector<WorldFromLandmark> places;
  std::vector<LandmarkSighting> sightings;

  TrackedPose tracked;
};

TEST(PictureRowTime, AsksThoseAsWellThatAWrongRowTimeMakesLookMoved) {
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    TwoSheets seen(seed);
    seen.roll(33e-6);
    for (const bool is_valid : {true, false}) {
      const auto evidence = seen.evidence(false, is_valid);
      ASSERT_TRUE(evidence) << seed;
      EXPECT_TRUE(evidence->is_of_left_out) << seed;
      const double sigma_s = 1 / std::sqrt(evidence->information_1_s2);
      EXPECT_NEAR(evidence->error_s, 33e-6, 4 * sigma_s) << seed;
      EXPECT_LT(sigma_s, 3e-6) << seed;
    }
  }
}

TEST(PictureRowTime, IsNotToldByASheetThatWasMoved) {
  for (std::uint64_t seed = 1; seed < 20; ++seed) {
    TwoSheets seen(seed);
    seen.places[1] = test::moved_sheet(seen.places[1]);
    EXPECT_FALSE(seen.evidence(false, false)) << seed << ": the place is not valid either";
    const auto evidence = seen.evidence(false, true);
    ASSERT_TRUE(evidence) << seed;
    EXPECT_GT(1 / std::sqrt(evidence->information_1_s2), 10e-6) << seed << ": by the other one alone";
    EXPECT_FALSE(evidence->is_of_left_out) << seed;
    EXPECT_LT(std::abs(evidence->error_s), 5 / std::sqrt(evidence->information_1_s2)) << seed;
  }
}

/// The row time is off by as much as the speed of the sheets.
TEST(PictureRowTime, SaysHowWellTheMotionIsKnown) {
  TwoSheets seen(1);
  seen.roll(33e-6);
  EXPECT_EQ(seen.evidence(true, true)->motion_share, 0);
  const double sigma_rad_s = 0.05 * TwoSheets::kTurning_rad_s.norm();
  seen.tracked.covariance.bottomRightCorner<3, 3>().diagonal().setConstant(sigma_rad_s * sigma_rad_s);
  EXPECT_NEAR(seen.evidence(true, true)->motion_share, 0.05 * std::sqrt(2.0), 0.015);
}

/// As a sheet that is warped by 0.1 mm, and one that hangs 1 mm beside its place at 2 m, look.
TEST(PictureRowTime, SaysWhatSheetsThatAreALittleOffWouldMakeOfIt) {
  TwoSheets seen(1);
  const double both_s = seen.evidence(true, true)->unexplained_s;
  EXPECT_GT(both_s, 1e-6);
  EXPECT_LT(both_s, 8e-6);
  seen.sightings.pop_back();
  EXPECT_GT(seen.evidence(true, true)->unexplained_s, both_s) << "one alone";
}

TEST(PictureRowTime, UncertainItWidensAPoseAlongItsWay) {
  TwoSheets seen(1);
  const CameraModel camera = test::camera_of_rooms();
  constexpr double kSigma_s = 1e-6;
  const PoseInformation share = row_time_share(seen.sightings[0], seen.motion_of(0), kSigma_s, {}, camera);
  EXPECT_TRUE(row_time_share(seen.sightings[0], seen.motion_of(0), 0, {}, camera).isZero(0));
  const CameraFromLandmark before = seen.sightings[0].T_camera_landmark;
  seen.roll(-kSigma_s);  // as a shutter that is faster than assumed: the row time grew by so much
  const auto from = before.inverse(), to = seen.sightings[0].T_camera_landmark.inverse();
  const PoseStep moved =
      step_between(WorldFromCamera{from.rotation, from.translation_m}, WorldFromCamera{to.rotation, to.translation_m});
  EXPECT_LT((moved * moved.transpose() - share).norm(), 0.1 * share.norm());
}

}  // namespace
}  // namespace ninedot
