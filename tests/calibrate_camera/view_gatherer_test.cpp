// A sheet before a camera, held by somebody: which of its pictures become views, and what is still wanted.
#include "calibrate_camera/view_gatherer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "calibrate_camera/sheet_attitude.h"
#include "calibrate_camera/sufficiency.h"
#include "tests/calibrate_camera/lens_scene.h"

namespace ninedot {
namespace {

const std::vector<PlaneDisc> kDiscs = discs_of(LandmarkGeometry{});

CameraModel barrel() {
  return {640, 480, 612.3, 611.1, 323.1, 236.4, DistortionModel::kPlumbBob, {-0.21, 0.06, 0.0007, -0.0004, 0.01}};
}

test::Picture picture_from(const test::Viewpoint& view) {
  return test::held_picture(barrel(), test::look_at_landmark(view), test::nine_dot_sheet(), 3);
}

/// A tenth of a millimetre at 0.5 m is an eighth of a pixel.
test::Picture picture_beside(double off_axis_rad) {
  test::Viewpoint view;
  view.distance_m = 0.5, view.tilt_rad = 0.4, view.off_axis_x_rad = off_axis_rad;
  return picture_from(view);
}

/// Each pixel the mean of its neighbourhood.
test::Picture blurred(const test::Picture& sharp, int reach_px) {
  test::Picture result = sharp;
  for (int y = reach_px; y < sharp.height_px - reach_px; ++y)
    for (int x = reach_px; x < sharp.width_px - reach_px; ++x) {
      int sum = 0;
      for (int dy = -reach_px; dy <= reach_px; ++dy)
        for (int dx = -reach_px; dx <= reach_px; ++dx) sum += sharp.view().at(x + dx, y + dy);
      const int count = (2 * reach_px + 1) * (2 * reach_px + 1);
      result.pixels[static_cast<std::size_t>(y * sharp.width_px + x)] = static_cast<std::uint8_t>(sum / count);
    }
  return result;
}

class Gathering : public testing::Test {
 protected:
  Looked look(const test::Picture& picture) { return gatherer_.look(finder_, picture.view(), SensorKind::kGrey); }

  LandmarkFinder finder_{usual_camera(640, 480), LandmarkGeometry{}};
  ViewGatherer gatherer_{640, kDiscs};
};

TEST_F(Gathering, TakesASheetThatStandsStillAndTakesItOnce) {
  const test::Picture picture = picture_beside(0);
  EXPECT_EQ(look(picture), Looked::kMoving);
  EXPECT_EQ(look(picture), Looked::kMoving);
  EXPECT_EQ(look(picture), Looked::kTaken);
  EXPECT_EQ(look(picture), Looked::kSeenBefore);
  EXPECT_EQ(gatherer_.views().size(), 1U);
  EXPECT_EQ(gatherer_.found(), 4U);
  EXPECT_EQ(gatherer_.newest().size(), kDotCount);
  const test::Picture elsewhere = picture_beside(0.1);
  EXPECT_EQ(look(elsewhere), Looked::kMoving);
  EXPECT_EQ(look(elsewhere), Looked::kMoving);
  EXPECT_EQ(look(elsewhere), Looked::kTaken);
}

TEST_F(Gathering, TakesNoneOfASheetThatMovesByAPixelFromPictureToPicture) {
  for (int i = 0; i < 6; ++i) EXPECT_EQ(look(picture_beside(0.0016 * i)), Looked::kMoving) << i;
  EXPECT_TRUE(gatherer_.views().empty());
}

TEST_F(Gathering, BeginsAnewWhenTheSheetWasGone) {
  const test::Picture picture = picture_beside(0);
  const test::Picture nothing{640, 480, std::vector<std::uint8_t>(640 * 480, 128)};
  look(picture), look(picture);
  EXPECT_EQ(look(nothing), Looked::kNoSheet);
  EXPECT_TRUE(gatherer_.newest().empty());
  EXPECT_EQ(look(picture), Looked::kMoving);
}

TEST_F(Gathering, TakesNoneThatIsBlurred) {
  const test::Picture picture = blurred(picture_beside(0), 5);  // as a point spread of 3.2 px
  look(picture), look(picture);
  EXPECT_EQ(look(picture), Looked::kBlurred);
  EXPECT_TRUE(gatherer_.views().empty());
}

TEST(SheetAttitude, TellsTiltSideAndSizeFromOnePictureOfALensThatIsNotKnown) {
  for (const double tilt_rad : {0.5, 0.75})
    for (int eighth = 0; eighth < 8; ++eighth) {
      test::Viewpoint view;
      view.distance_m = 0.5, view.tilt_rad = tilt_rad, view.azimuth_rad = eighth * M_PI / 4;
      const test::CameraPose pose = test::look_at_landmark(view);
      const SheetView seen = test::perfect_view(barrel(), pose, kDiscs, 0, 1);
      const auto attitude = attitude_of(seen.seen, kDiscs, 480);
      ASSERT_TRUE(attitude.has_value());
      EXPECT_NEAR(attitude->tilt_rad, tilt_rad, 0.06);
      EXPECT_NEAR(attitude->height_share, 2 * 0.08 / 0.5 * 612 / 480, 0.03);
      // n.p = const, and n looks at the camera: depth grows along what n has in the picture's plane.
      const CameraFromLandmark T = test::sheet_before(pose);
      const Eigen::Vector3d normal = T.rotation * Eigen::Vector3d::UnitY();
      ASSERT_LT(normal.z(), 0);
      EXPECT_GT(attitude->away.dot(normal.head<2>().normalized()), 0.95) << eighth;
    }
}

/// What one held sheet counts as.
std::string name_of_view(double tilt_rad, double azimuth_rad) {
  test::Viewpoint view;
  view.distance_m = 0.9, view.tilt_rad = tilt_rad, view.azimuth_rad = azimuth_rad;
  const SheetView seen = test::perfect_view(barrel(), test::look_at_landmark(view), kDiscs, 0, 1);
  const ViewTally tally = tally_of(std::vector{seen}, kDiscs, 640, 480);
  for (std::size_t i = 0; i < kTiltNames.size(); ++i)
    if (tally.tilts[i] > 0) return kTiltNames[i];
  return tally.near > 0 ? "near" : "";
}

TEST(Sufficiency, CountsTiltsByTheSideThatIsFurthestAway) {
  EXPECT_EQ(name_of_view(0, 0), "");
  EXPECT_EQ(name_of_view(0.3, 0), "");  // 17 degrees
  std::vector<std::string> seen;
  for (const double azimuth_rad : {0.0, M_PI / 2, M_PI, 3 * M_PI / 2}) {
    seen.push_back(name_of_view(0.6, azimuth_rad));
    EXPECT_EQ(std::ranges::count(seen, seen.back()), 1) << seen.back();
  }
}

std::vector<std::string> names_of(const std::vector<Want>& wanted) {
  std::vector<std::string> names;
  for (const Want& want : wanted) names.push_back(name_of(want));
  return names;
}

TEST(Sufficiency, WantsWhatIsMissingByName) {
  ViewTally tally;
  tally.views = 30, tally.near = 6;
  tally.parts.fill(3), tally.tilts.fill(4);
  EXPECT_TRUE(wanted_views(tally).empty());
  ViewGoals goals;
  goals.views = 42;
  EXPECT_EQ(names_of(wanted_views(tally, goals)), std::vector<std::string>{"12 more"});
  goals.parts[2] = 5;
  EXPECT_EQ(names_of(wanted_views(tally, goals)), std::vector<std::string>{"upper right"});
  tally.parts[6] = 2, tally.tilts[0] = 3, tally.near = 5, tally.views = 20;
  EXPECT_EQ(names_of(wanted_views(tally)), (std::vector<std::string>{"lower left", "tilted to the right", "nearer"}));
}

TEST(Sufficiency, NamesThePartsThatAreLessCertainThanTheRest) {
  LensCalibration calibration;
  calibration.directions = {640, 480, std::vector<double>(DirectionErrors::kColumns * DirectionErrors::kRows, 0.05)};
  EXPECT_TRUE(uncertain_parts(calibration).empty());
  calibration.directions.sigma_px.back() = 0.2;
  const std::vector<UncertainPart> uncertain = uncertain_parts(calibration);
  ASSERT_EQ(uncertain.size(), 1U);
  EXPECT_STREQ(kPartNames[uncertain[0].part], "lower right");
  EXPECT_EQ(uncertain[0].sigma_px, 0.2);
}

TEST(Sufficiency, LacksNothingOnceNothingIsWanted) {
  std::vector<SheetView> views;
  for (std::uint64_t i = 0; i < 400; ++i) {
    SheetView view = test::perfect_view(barrel(), test::held_pose(barrel(), {}, 11, i), kDiscs, 0.02, i);
    if (view.seen.size() < 5) continue;
    views.push_back(std::move(view));
    if (wanted_views(tally_of(views, kDiscs, 640, 480)).empty()) break;
  }
  EXPECT_LT(views.size(), 80U) << "held as the page says, it ends";
  EXPECT_TRUE(what_views_lack(views, views.size(), 640, 480).empty());
}

}  // namespace
}  // namespace ninedot
