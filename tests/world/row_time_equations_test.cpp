#include "world/row_time_equations.h"

#include <gtest/gtest.h>

#include <cmath>
#include <optional>
#include <vector>

#include "tests/world/room.h"

namespace ninedot {
namespace {

using test::Random;

/// Two landmarks before a camera that moves, their dots where a rolling shutter shows them.
struct View {
  test::Room room;
  Eigen::Vector3d turning_rad_s{0, 0, 0}, velocity_m_s{0, 0, 0};  // of the camera, its own axes
  std::vector<LandmarkSighting> sightings;

  SheetMotion motion_of(std::size_t i, double assumed_s) const {
    const CameraFromLandmark T = room.T_world_camera.inverse() * room.map[i].T_world_landmark;
    return {-turning_rad_s, -turning_rad_s.cross(T.translation_m) - velocity_m_s, assumed_s,
            0.5 * (test::camera_of_rooms().height_px - 1)};
  }
};

/// \param noisy  else the dots lie exactly where they are
View view_of(Random& random, double row_time_s, bool noisy) {
  View view;
  view.room = test::random_room(random, {.landmarks = 2, .nearest_m = 1.5, .farthest_m = 3});
  for (double& component : view.turning_rad_s) component = random.uniform(-0.7, 0.7);
  for (double& component : view.velocity_m_s) component = random.uniform(-1, 1);
  const CameraModel camera = test::camera_of_rooms();
  for (std::size_t i = 0; i < view.room.map.size(); ++i) {
    const WorldFromLandmark& place = view.room.map[i].T_world_landmark;
    LandmarkSighting seen = test::sighting_of(random, view.room.T_world_camera, place).sighting;
    const CameraFromLandmark T = view.room.T_world_camera.inverse() * place;
    const SheetMotion motion = view.motion_of(i, 0);
    for (std::size_t dot = 0; dot < kDotCount; ++dot) {
      const Eigen::Vector2d C = LandmarkGeometry{}.centre_m(dot);
      const Eigen::Vector3d on_sheet_m(C.x(), 0, C.y());
      const Eigen::Vector2d at_middle = (T * on_sheet_m).hnormalized();
      Eigen::Vector2d ray = at_middle;
      for (int round = 0; round < 5; ++round) {  // the row depends on the place
        const double after_s = (camera.pixel_from_normalised(ray).y() - motion.middle_row_px) * row_time_s;
        ray = (motion.after(T, after_s) * on_sheet_m).hnormalized();
      }
      seen.dots[dot].ray = noisy ? Eigen::Vector2d(ray + seen.dots[dot].ray - at_middle) : ray;
    }
    view.sightings.push_back(seen);
  }
  return view;
}

std::optional<RowTimeEvidence> evidence_in(const View& view, double assumed_s,
                                           const PoseCovariance* place_covariance = nullptr) {
  RowTimeEquations sum;
  for (std::size_t i = 0; i < view.sightings.size(); ++i)
    sum += equations_of_member({&view.sightings[i], view.room.map[i].T_world_landmark, place_covariance},
                               view.motion_of(i, assumed_s), view.motion_of(i, 0), view.room.T_world_camera, {},
                               test::camera_of_rooms());
  return evidence_of(sum);
}

TEST(RowTimeEquations, FindWhatTheRowTimeIsOffByWhateverTheCamerasPlace) {
  Random random(71);
  for (int trial = 0; trial < 50; ++trial) {
    constexpr double kTrue_s = 5e-6;
    View view = view_of(random, kTrue_s, false);
    const auto evidence = evidence_in(view, 0);
    ASSERT_TRUE(evidence) << trial;
    const double sigma_s = 1 / std::sqrt(evidence->information_1_s2);
    EXPECT_NEAR(evidence->error_s, kTrue_s, 0.05 * kTrue_s + 0.1 * sigma_s) << trial;
    // From a place beside the true one it is the same: that is eliminated.
    view.room.T_world_camera = moved_by(view.room.T_world_camera, PoseStep::Constant(1e-4));
    EXPECT_NEAR(evidence_in(view, 0)->error_s, evidence->error_s, 0.1 * sigma_s) << trial;
  }
}

TEST(RowTimeEquations, ErrorsAreAsLargeAsTheySay) {
  Random random(72);
  double squares = 0;
  constexpr int kTrials = 300;
  for (int trial = 0; trial < kTrials; ++trial) {
    const auto evidence = evidence_in(view_of(random, 2e-6, true), 0);
    ASSERT_TRUE(evidence);
    squares += std::pow(evidence->error_s - 2e-6, 2) * evidence->information_1_s2;
  }
  EXPECT_NEAR(std::sqrt(squares / kTrials), 1, 0.12);
}

TEST(RowTimeEquations, SayHowTheirPlaceMovesWithTheRowTime) {
  Random random(73);
  for (int trial = 0; trial < 20; ++trial) {
    const View still = view_of(random, 0, false);
    View rolled = still;
    constexpr double kStep_s = 1e-7;
    const CameraModel camera = test::camera_of_rooms();
    std::vector<JointMember> members;
    for (std::size_t i = 0; i < rolled.sightings.size(); ++i) {
      // As if they had been taken to the middle row with kStep_s too much.
      const CameraFromLandmark T = still.room.T_world_camera.inverse() * still.room.map[i].T_world_landmark;
      const SheetMotion motion = still.motion_of(i, kStep_s);
      for (std::size_t dot = 0; dot < kDotCount; ++dot) {
        const Eigen::Vector2d C = LandmarkGeometry{}.centre_m(dot);
        Eigen::Vector2d& ray = rolled.sightings[i].dots[dot].ray;
        ray -= motion.since_s(camera.pixel_from_normalised(ray).y()) *
               motion.ray_velocity(T * Eigen::Vector3d(C.x(), 0, C.y()), T.translation_m);
      }
      members.push_back({&rolled.sightings[i], still.room.map[i].T_world_landmark, nullptr});
    }
    JointFit fit;
    fit_jointly(members, still.room.T_world_camera, {}, fit);
    const PoseStep moved = step_between(still.room.T_world_camera, fit.T_world_camera);
    const PoseStep foretold = kStep_s * evidence_in(still, 0)->step_by_row_time;
    EXPECT_LT((moved - foretold).norm(), 0.02 * foretold.norm() + 1e-9) << trial;
  }
}

/// Dots that were taken to the middle row with another motion than is known afterwards.
TEST(RowTimeEquations, TakeBackWhatTheDotsWereTakenByTooMuch) {
  Random random(76);
  for (int trial = 0; trial < 20; ++trial) {
    constexpr double kAssumed_s = 5e-6;
    View view = view_of(random, kAssumed_s, false);
    RowTimeEquations sum;
    for (std::size_t i = 0; i < view.sightings.size(); ++i) {
      SheetMotion taken_by = view.motion_of(i, kAssumed_s);
      taken_by.translation_m_s *= 0.5;
      const CameraFromLandmark T = view.room.T_world_camera.inverse() * view.room.map[i].T_world_landmark;
      for (std::size_t dot = 0; dot < kDotCount; ++dot) {
        const Eigen::Vector2d C = LandmarkGeometry{}.centre_m(dot);
        Eigen::Vector2d& ray = view.sightings[i].dots[dot].ray;
        ray -= taken_by.since_s(test::camera_of_rooms().pixel_from_normalised(ray).y()) *
               taken_by.ray_velocity(T * Eigen::Vector3d(C.x(), 0, C.y()), T.translation_m);
      }
      sum += equations_of_member({&view.sightings[i], view.room.map[i].T_world_landmark, nullptr}, taken_by,
                                 view.motion_of(i, 0), view.room.T_world_camera, {}, test::camera_of_rooms());
    }
    const auto evidence = evidence_of(sum);
    ASSERT_TRUE(evidence);
    EXPECT_NEAR(evidence->error_s, 0, 0.05 * kAssumed_s + 0.1 / std::sqrt(evidence->information_1_s2)) << trial;
  }
}

TEST(RowTimeEquations, AMapThatIsUncertainSaysLess) {
  Random random(74);
  const View view = view_of(random, 5e-6, false);
  const PoseCovariance loose = 1e-4 * PoseCovariance::Identity();
  EXPECT_LT(evidence_in(view, 0, &loose)->information_1_s2, 0.5 * evidence_in(view, 0)->information_1_s2);
}

TEST(RowTimeEquations, NothingMovesAndNothingIsSaid) {
  Random random(75);
  View view = view_of(random, 0, true);
  view.turning_rad_s.setZero(), view.velocity_m_s.setZero();
  const auto evidence = evidence_in(view, 0);
  ASSERT_TRUE(evidence);
  EXPECT_EQ(evidence->information_1_s2, 0);
  EXPECT_EQ(evidence->step_by_row_time.norm(), 0);
  view.sightings.clear();
  EXPECT_FALSE(evidence_in(view, 0)) << "nor a place";
}

}  // namespace
}  // namespace ninedot
