// The ghost that somebody is to bring the sheet to: who does gets the view that was wanted.
#include "calibrate_camera/wanted_pose.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "calibrate_camera/view_gatherer.h"
#include "tests/calibrate_camera/lens_scene.h"

namespace ninedot {
namespace {

const std::vector<PlaneDisc> kDiscs = discs_of(LandmarkGeometry{});

CameraModel plain() { return usual_camera(640, 480); }
CameraModel barrel() {
  return {640, 480, 402.7, 403.5, 314.2, 244.9, DistortionModel::kPlumbBob, {-0.30, 0.11, -0.0006, 0.0008, -0.016}};
}
CameraModel fisheye() {
  return {640, 480, 262.4, 262.9, 317.8, 241.6, DistortionModel::kEquidistant, {0.021, -0.009, 0.004, -0.001}};
}

/// A camera that is where the ghost has it, before the sheet.
test::CameraPose camera_at(const CameraFromLandmark& T_camera_sheet) {
  const Eigen::Matrix3d rotation = T_camera_sheet.rotation.transpose();
  const Eigen::Vector3d position = -(rotation * T_camera_sheet.translation_m);
  const Eigen::Quaterniond q(rotation);
  return {{position.x(), position.y(), position.z()}, {q.w(), q.x(), q.y(), q.z()}};
}

std::vector<Want> every_want() {
  std::vector<Want> wanted;
  for (std::size_t part = 0; part < kPartNames.size(); ++part) wanted.push_back({Want::Kind::kPart, part});
  for (std::size_t tilt = 0; tilt < kTiltNames.size(); ++tilt) wanted.push_back({Want::Kind::kTilt, tilt});
  wanted.push_back({Want::Kind::kNearer, 0});
  wanted.push_back({Want::Kind::kMore, 5});
  return wanted;
}

class Ghost : public testing::TestWithParam<CameraModel> {
 protected:
  /// Holds the sheet where the ghost is, for three pictures. \return  what became of the last one
  Looked hold(const CameraFromLandmark& T) {
    const test::Picture picture = test::held_picture(GetParam(), camera_at(T), test::nine_dot_sheet(), ++seed_);
    for (int i = 0; i < 2; ++i) gatherer_.look(finder_, picture.view(), SensorKind::kGrey);
    return gatherer_.look(finder_, picture.view(), SensorKind::kGrey);
  }
  ViewTally tally() const { return tally_of(gatherer_.views(), kDiscs, 640, 480); }

  LandmarkFinder finder_{GetParam(), LandmarkGeometry{}};
  ViewGatherer gatherer_{640, kDiscs};
  std::uint64_t seed_ = 0;
};

INSTANTIATE_TEST_SUITE_P(Lenses, Ghost, testing::Values(plain(), barrel(), fisheye()));

TEST_P(Ghost, GivesEachKindOfViewToWhoHoldsTheSheetThere) {
  for (const Want& want : every_want()) {
    ViewGatherer fresh(640, kDiscs);
    gatherer_ = std::move(fresh);
    const auto pose = pose_for(std::vector{want}, GetParam(), kDiscs, gatherer_.collection());
    ASSERT_TRUE(pose.has_value()) << name_of(want);
    EXPECT_EQ(hold(pose->T_camera_sheet), Looked::kTaken) << name_of(want);
    EXPECT_TRUE(is_wanted(want, tally())) << name_of(want);
  }
}

/// Not of the fisheye: between 60 and 66 degrees off its axis the search misses one in ten sheets that stand well.
using GhostOfALens = Ghost;
INSTANTIATE_TEST_SUITE_P(Lenses, GhostOfALens, testing::Values(plain(), barrel()));

TEST_P(GhostOfALens, LeadsFromTheFirstViewToTheLastOne) {
  int asked = 0;
  for (std::vector<Want> wanted = wanted_views(tally()); !wanted.empty(); wanted = wanted_views(tally())) {
    const auto pose = pose_for(wanted, GetParam(), kDiscs, gatherer_.collection());
    ASSERT_TRUE(pose.has_value()) << name_of(wanted.front()) << " after " << asked;
    const ViewTally before = tally();
    ASSERT_EQ(hold(pose->T_camera_sheet), Looked::kTaken) << name_of(wanted.front()) << " after " << asked;
    ASSERT_EQ(tally().views, before.views + 1);
    for (const std::size_t met : pose->meets) {
      const ViewTally one = tally_of(std::span(&gatherer_.views().back(), 1), kDiscs, 640, 480);
      EXPECT_TRUE(is_wanted(wanted[met], one)) << name_of(wanted[met]) << " after " << asked;
    }
    ASSERT_LE(++asked, 45);
  }
  EXPECT_GE(tally().views, ViewGoals{}.views);
  EXPECT_TRUE(what_views_lack(gatherer_.views(), gatherer_.found(), 640, 480).empty());
}

TEST(GhostAlone, IsNoneWhereNothingIsWanted) {
  EXPECT_FALSE(pose_for({}, plain(), kDiscs, ViewCollection(640)).has_value());
}

TEST(GhostAlone, IsWhollyInThePictureWithItsSheetAroundItsDiscs) {
  const auto pose = pose_for(std::vector{Want{Want::Kind::kPart, 2}}, plain(), kDiscs, ViewCollection(640));
  ASSERT_TRUE(pose.has_value());
  const auto outlines = outlines_of(map_of_camera(plain(), pose->T_camera_sheet), kDiscs);
  ASSERT_EQ(outlines.size(), 1 + kDiscs.size());
  Eigen::AlignedBox2d sheet, dots;
  for (const Eigen::Vector2d& point : outlines.front()) sheet.extend(point);
  for (auto disc = outlines.begin() + 1; disc != outlines.end(); ++disc)
    for (const Eigen::Vector2d& point : *disc) dots.extend(point);
  EXPECT_TRUE(sheet.contains(dots));
  EXPECT_GE(dots.min().x(), 213) << "in the right third, or nearly";
  EXPECT_LE(dots.max().x(), 639);
  EXPECT_GE(dots.min().y(), 0);
  EXPECT_LE(dots.min().y(), 25) << "right in the corner";
}

TEST(GhostAlone, DrawsNoDiscsOfAGrid) {
  const std::vector<PlaneDisc> grid = discs_of(DotGrid{9, 7, 0.025});
  const auto pose = pose_for(std::vector{Want{Want::Kind::kNearer, 0}}, plain(), grid, ViewCollection(640));
  ASSERT_TRUE(pose.has_value());
  EXPECT_EQ(outlines_of(map_of_camera(plain(), pose->T_camera_sheet), grid).size(), 1U);
}

}  // namespace
}  // namespace ninedot
