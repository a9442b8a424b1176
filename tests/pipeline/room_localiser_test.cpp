// Several landmarks, and coded ones, from picture to the camera's place in the world.
#include "pipeline/room_localiser.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "base/units.h"
#include "pipeline/next_report.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/colour_renderer.h"
#include "tests/support/renderer.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

/// On the wall, which is the plane y = 0 of the world; sheets look along +y, and their dots are given from their
/// middle.
struct Hung {
  std::uint16_t id;
  double x_m, z_m;
};

test::Sheet sheet_at(const Hung& hung) {
  test::Sheet sheet = test::nine_dot_sheet();
  sheet.x_m = hung.x_m, sheet.z_m = hung.z_m;
  return sheet;
}

MappedLandmark mapped(const Hung& hung, std::string_view code = "") {
  return {hung.id, std::string(code), place_upright({hung.x_m, 0, hung.z_m}, 0)};
}

/// No two pairs of them are alike.
const Hung kWall[] = {{1, -0.45, 0.05}, {2, 0.0, -0.12}, {3, 0.62, 0.2}};

LandmarkMap map_of_wall() { return LandmarkMap({mapped(kWall[0]), mapped(kWall[1]), mapped(kWall[2])}); }

test::Scene scene_of(std::initializer_list<Hung> hung, const test::Viewpoint& viewpoint) {
  test::Scene scene;
  scene.camera = test::look_at_landmark(viewpoint);
  scene.sheets.clear();
  for (const Hung& one : hung) scene.sheets.push_back(sheet_at(one));
  set_noise(scene.sensor, 1.5);
  return scene;
}

const test::Viewpoint kFromAside{.distance_m = 2.2, .tilt_rad = 0.4, .azimuth_rad = 0.2};

Frame frame_of(const test::Picture& picture, std::uint64_t number) {
  Frame frame;
  frame.number = number;
  frame.luma = picture.view();
  frame.set_exposure(MonoTime(5s + number * 28ms));
  return frame;
}

double apart_m(const Eigen::Vector3d& p, const test::CameraPose& camera) {
  return (p - Eigen::Vector3d(camera.position_m[0], camera.position_m[1], camera.position_m[2])).norm();
}

TEST(RoomLocaliser, PlacesTheCameraByAllSheetsInView) {
  const test::Scene scene = scene_of({kWall[0], kWall[1], kWall[2]}, kFromAside);
  const test::Picture picture = test::render(scene, 1);
  RoomLocaliser unit(CameraModel{}, {.row_time = 0ns, .map = map_of_wall()});
  const Fix& fix = unit.process(frame_of(picture, 1));
  EXPECT_EQ(fix.reason, Reason::kNone);
  ASSERT_EQ(fix.landmarks.size(), 3U);
  for (const LandmarkFix& landmark : fix.landmarks) {
    const Hung& hung = kWall[landmark.id - 1];
    const Eigen::Vector3d p = landmark.pose().T_landmark_camera.translation_m + Eigen::Vector3d(hung.x_m, 0, hung.z_m);
    EXPECT_EQ(landmark.verdict, Reason::kNone);
    EXPECT_LT(apart_m(p, scene.camera), 0.03) << landmark.id << " is what it is called";
  }
  ASSERT_TRUE(fix.world);
  EXPECT_EQ(fix.world->used.size(), 3U);
  const double sigma_m = std::sqrt(fix.world->covariance.topLeftCorner<3, 3>().trace());
  EXPECT_LT(apart_m(fix.world->T_world_camera.translation_m, scene.camera), 3 * sigma_m);
  EXPECT_LT(sigma_m, 0.004) << "together they are better than each";
  ASSERT_TRUE(fix.track);
  EXPECT_LT(apart_m(fix.track->motion.T_world_camera.translation_m, scene.camera), 0.01);
}

/// Without tracking every picture is a first one, and no camera would ever be known to stand.
TEST(RoomLocaliser, WithoutTrackingAShutterThatNobodyToldOfCountsAsOneOfACameraThatStands) {
  const test::Picture picture = test::render(scene_of({kWall[0], kWall[1], kWall[2]}, kFromAside), 1);
  const auto sigma_m = [&](bool tracking) {
    RoomLocaliser unit(CameraModel{}, {.tracking = tracking, .map = map_of_wall()});
    const Fix& fix = unit.process(frame_of(picture, 1));
    return fix.world ? std::sqrt(fix.world->covariance.topLeftCorner<3, 3>().trace()) : 1.0;
  };
  EXPECT_LT(sigma_m(false), 0.004);
  EXPECT_GT(sigma_m(true), 0.008) << "the camera may move in a first picture";
}

TEST(RoomLocaliser, ReportsTheNearestOrTheSurestOfThem) {
  const test::Picture picture =
      test::render(scene_of({kWall[0], kWall[1], kWall[2]}, {.distance_m = 2.2, .tilt_rad = 0.1}), 1);
  const auto by_distance = [](const LandmarkFix& a, const LandmarkFix& b) {
    return a.pose().T_landmark_camera.translation_m.norm() < b.pose().T_landmark_camera.translation_m.norm();
  };
  const auto by_variance = [](const LandmarkFix& a, const LandmarkFix& b) {
    return a.pose().covariance.topLeftCorner<3, 3>().trace() < b.pose().covariance.topLeftCorner<3, 3>().trace();
  };
  const auto is_first = [&](MainLandmark choice, auto comes_before) {
    RoomLocaliser unit(CameraModel{}, {.map = map_of_wall(), .main_landmark = choice});
    const Fix& fix = unit.process(frame_of(picture, 1));
    EXPECT_EQ(fix.landmarks.size(), 3U);
    return std::ranges::min_element(fix.landmarks, comes_before) == fix.landmarks.begin();
  };
  EXPECT_TRUE(is_first(MainLandmark::kNearest, by_distance));
  EXPECT_FALSE(is_first(MainLandmark::kNearest, by_variance)) << "or this picture tests nothing";
  EXPECT_TRUE(is_first(MainLandmark::kSurest, by_variance));
}

TEST(RoomLocaliser, FollowsThemFromFrameToFrame) {
  const test::Picture picture = test::render(scene_of({kWall[0], kWall[1], kWall[2]}, kFromAside), 1);
  RoomLocaliser unit(CameraModel{}, {.map = map_of_wall()});
  EXPECT_FALSE(unit.process(frame_of(picture, 1)).tracked);
  for (std::uint64_t number = 2; number < 5; ++number) {
    const Fix& fix = unit.process(frame_of(picture, number));
    EXPECT_TRUE(fix.tracked);
    EXPECT_EQ(fix.landmarks.size(), 3U);
  }
}

TEST(RoomLocaliser, NamesASheetThatWasMovedAndDoesWithoutIt) {
  Hung moved = kWall[1];
  moved.x_m += 0.15;
  const test::Scene scene = scene_of({kWall[0], moved, kWall[2]}, kFromAside);
  const test::Picture picture = test::render(scene, 1);
  RoomLocaliser unit(CameraModel{}, {.row_time = 0ns, .map = map_of_wall()});
  const Fix& fix = unit.process(frame_of(picture, 1));
  ASSERT_TRUE(fix.world);
  EXPECT_EQ(fix.world->used.size(), 2U);
  ASSERT_EQ(fix.rejected.size(), 1U);
  EXPECT_EQ(fix.rejected[0], 2);
  EXPECT_LT(apart_m(fix.world->T_world_camera.translation_m, scene.camera), 0.02);
}

TEST(RoomLocaliser, GuessesNothingOfOneSheetAmongThreeAlike) {
  const test::Picture picture = test::render(scene_of({kWall[1]}, kFromAside), 1);
  RoomLocaliser unit(CameraModel{}, {.map = map_of_wall()});
  const Fix& fix = unit.process(frame_of(picture, 1));
  EXPECT_TRUE(fix.found);
  EXPECT_FALSE(fix.world);
  EXPECT_NE(fix.reason, Reason::kNone);
}

TEST(RoomLocaliser, KnowsOneSheetAmongThreeAlikeOnceItHasSeenTheOthers) {
  RoomLocaliser unit(CameraModel{}, {.map = map_of_wall()});
  const test::Picture all = test::render(scene_of({kWall[0], kWall[1], kWall[2]}, kFromAside), 1);
  for (std::uint64_t number = 1; number < 4; ++number) unit.process(frame_of(all, number));
  const test::Scene scene = scene_of({kWall[1]}, kFromAside);
  const test::Picture one = test::render(scene, 2);
  const Fix& fix = unit.process(frame_of(one, 4));
  ASSERT_EQ(fix.landmarks.size(), 1U);
  EXPECT_EQ(fix.main().id, 2);
  EXPECT_EQ(fix.reason, Reason::kNone);
  ASSERT_TRUE(fix.world);
  EXPECT_LT(apart_m(fix.world->T_world_camera.translation_m, scene.camera), 0.03);
}

/// \param others  black and white
test::ColourPicture coded_picture(std::string_view code, const test::Viewpoint& viewpoint, std::uint64_t seed,
                                  const std::vector<Hung>& others = {}) {
  test::ColourScene colours;
  colours.scene = scene_of({{0, 0, 0}}, viewpoint);
  for (const Hung& other : others) colours.scene.sheets.push_back(sheet_at(other));
  for (const char letter : code)
    colours.discs.push_back(letter == 'R'   ? test::linear_of_srgb(190, 40, 50)
                            : letter == 'G' ? test::linear_of_srgb(40, 140, 70)
                            : letter == 'B' ? test::linear_of_srgb(40, 70, 160)
                                            : test::linear_of_srgb(45, 45, 48));
  colours.discs.push_back(test::linear_of_srgb(45, 45, 48));
  return test::render_colour(colours, test::ChromaLayout::k420, seed);
}

Frame frame_of(const test::ColourPicture& picture, std::uint64_t number) {
  Frame frame = frame_of(picture.luma, number);
  frame.chroma = picture.chroma();
  return frame;
}

LandmarkMap map_of_codes() {
  return LandmarkMap({mapped({11, 0, 0}, "KRGBKKRB"), mapped({12, 3, 0}, "RRGKBGKB"), mapped({13, 6, 0}, "KKGRRBGB"),
                      mapped({14, 9, 0})});
}

/// It says where the camera would be, had nobody moved it.
TEST(RoomLocaliser, NamesASheetThatWasMovedAlsoWhereItIsAloneInView) {
  const auto map = LandmarkMap({mapped({11, -0.15, 0}, "KRGBKKRB"), mapped({12, 0.4, 0}), mapped({13, -0.6, 0})});
  const test::ColourPicture all = coded_picture("KRGBKKRB", kFromAside, 3, {{12, 0.4, 0}, {13, -0.6, 0}});
  const test::ColourPicture alone = coded_picture("KRGBKKRB", kFromAside, 4);
  RoomLocaliser unit(CameraModel{}, {.row_time = 0ns, .map = map});
  EXPECT_TRUE(unit.process(frame_of(all, 1)).world);
  const Fix& fix = unit.process(frame_of(alone, 2));
  EXPECT_FALSE(fix.world);
  EXPECT_EQ(fix.reason, Reason::kMoved);
  ASSERT_EQ(fix.rejected.size(), 1U);
  EXPECT_EQ(fix.rejected[0], 11);
  const Report report = next_report({}, frame_of(alone, 2), fix, {});
  EXPECT_FALSE(report.valid);
  EXPECT_EQ(report.landmarks_rejected, 1);
  EXPECT_EQ(report.last_rejected_id, 11);
  EXPECT_EQ(unit.process(frame_of(all, 3)).rejected.size(), 1U) << "and once in a frame";
}

/// The roll would have it numbered otherwise, were it black and white.
TEST(RoomLocaliser, KnowsACodedSheetByItsColoursAtAnyRoll) {
  for (const double roll_rad : {0.0, 1.7, -2.6}) {
    test::Viewpoint viewpoint = kFromAside;
    viewpoint.distance_m = 1.4;
    viewpoint.roll_rad = roll_rad;
    const test::ColourPicture picture = coded_picture("KRGBKKRB", viewpoint, 3);
    RoomLocaliser unit(CameraModel{}, {.map = map_of_codes()});
    const Fix& fix = unit.process(frame_of(picture, 1));
    ASSERT_EQ(fix.landmarks.size(), 1U) << roll_rad;
    EXPECT_EQ(fix.main().id, 11);
    EXPECT_EQ(fix.reason, Reason::kNone);
    EXPECT_LT(fix.main().pose().ambiguity, 0.01);
    EXPECT_LT(apart_m(fix.main().pose().T_landmark_camera.translation_m, test::look_at_landmark(viewpoint)), 0.02);
    ASSERT_TRUE(fix.world);
  }
}

/// What is reported as the camera in the world would be one at a sheet, and at another one once that is nearer.
TEST(RoomLocaliser, HasNoPlaceInTheWorldByASheetThatNobodyHasPlaced) {
  test::Viewpoint viewpoint = kFromAside;
  viewpoint.distance_m = 1.4;
  const test::ColourPicture picture = coded_picture("KRGBKKRB", viewpoint, 3);
  const LandmarkMap placed = map_of_codes();
  std::vector<MappedLandmark> landmarks(placed.landmarks().begin(), placed.landmarks().end());
  for (MappedLandmark& landmark : landmarks)
    landmark.has_place = landmark.id != 11, landmark.T_world_landmark = WorldFromLandmark{};
  for (const bool needs_place : {true, false}) {
    RoomLocaliser unit(CameraModel{}, {.map = LandmarkMap(landmarks), .needs_place = needs_place});
    const Fix& fix = unit.process(frame_of(picture, 1));
    ASSERT_EQ(fix.landmarks.size(), 1U);
    EXPECT_EQ(fix.main().id, 11);
    EXPECT_FALSE(fix.world);
    EXPECT_EQ(fix.reason, needs_place ? Reason::kUncertain : Reason::kNone);
    EXPECT_EQ(next_report({}, frame_of(picture, 1), fix, {}).valid, !needs_place);
  }
}

TEST(RoomLocaliser, SaysThatACodeOfAnotherMapIsNoneOfIts) {
  test::Viewpoint viewpoint = kFromAside;
  viewpoint.distance_m = 1.4;
  const test::ColourPicture picture = coded_picture("RKBGGKRB", viewpoint, 3);
  RoomLocaliser unit(CameraModel{}, {.map = map_of_codes()});
  for (std::uint64_t number = 1; number < 4; ++number) {
    const Fix& fix = unit.process(frame_of(picture, number));
    EXPECT_TRUE(fix.landmarks.empty());
    EXPECT_EQ(fix.reason, Reason::kNotIdentified);
    EXPECT_FALSE(fix.world);
  }
}

/// A sheet of nobody's is followed all the while.
TEST(RoomLocaliser, SearchesOnWhileNobodyInViewIsOfItsMap) {
  test::Viewpoint viewpoint = kFromAside;
  viewpoint.distance_m = 1.8;
  const test::ColourPicture foreign = coded_picture("RKBGGKRB", viewpoint, 3);
  const test::ColourPicture both = coded_picture("RKBGGKRB", viewpoint, 4, {{14, 0.5, 0}});
  RoomLocaliser unit(CameraModel{}, {.map = map_of_codes()});
  for (std::uint64_t number = 1; number < 4; ++number) {
    EXPECT_EQ(unit.process(frame_of(foreign, number)).reason, Reason::kNotIdentified);
  }
  const Fix& fix = unit.process(frame_of(both, 4));
  ASSERT_EQ(fix.landmarks.size(), 1U) << "at once, not at the next search of every tenth frame";
  EXPECT_EQ(fix.main().id, 14);
}

TEST(RoomLocaliser, SearchesOnWhileWhatIsInViewDoesNotTellWhereTheCameraIs) {
  const test::Picture one = test::render(scene_of({kWall[1]}, kFromAside), 1);
  const test::Picture all = test::render(scene_of({kWall[0], kWall[1], kWall[2]}, kFromAside), 2);
  RoomLocaliser unit(CameraModel{}, {.map = map_of_wall()});
  for (std::uint64_t number = 1; number < 4; ++number) {
    const Fix& fix = unit.process(frame_of(one, number));
    EXPECT_TRUE(fix.found);
    EXPECT_FALSE(fix.world);
  }
  const Fix& fix = unit.process(frame_of(all, 4));
  ASSERT_TRUE(fix.world) << "at once, not at the next search of every tenth frame";
  EXPECT_EQ(fix.world->used.size(), 3U);
}

/// A search came upon it while the map had it looked for in every other frame only. Grey frames tell no colours.
TEST(RoomLocaliser, KnowsByItsPlaceWhomASearchCameUpon) {
  const auto map = LandmarkMap({mapped({11, 0.5, 0}, "KRGBKKRB"), mapped({12, 0, 0}), mapped({13, -0.6, 0.1})});
  const test::ColourPicture two = coded_picture("KKKKKKKK", kFromAside, 3, {{13, -0.6, 0.1}});
  const test::ColourPicture all = coded_picture("KKKKKKKK", kFromAside, 4, {{13, -0.6, 0.1}, {11, 0.5, 0}});
  RoomLocaliser unit(CameraModel{}, {.row_time = 0ns, .map = map, .search_every = 1});
  ASSERT_TRUE(unit.process(frame_of(two, 1)).world);
  for (std::uint64_t number = 2; number < 4; ++number)
    ASSERT_EQ(unit.process(frame_of(two, number)).landmarks.size(), 2U);
  ASSERT_EQ(unit.process(frame_of(all.luma, 4)).landmarks.size(), 2U) << "or this tests nothing";
  unit.process(frame_of(all.luma, 5));
  const Fix& fix = unit.process(frame_of(all.luma, 6));
  ASSERT_TRUE(fix.world);
  EXPECT_EQ(fix.world->used.size(), 3U);
}

/// The next search of every tenth frame would come five frames later.
TEST(RoomLocaliser, SearchesBesideThePlaceWhereOneShouldHang) {
  Hung moved = kWall[2];
  moved.x_m -= 0.2;
  const test::Picture two = test::render(scene_of({kWall[0], kWall[1]}, kFromAside), 1);
  const test::Picture all = test::render(scene_of({kWall[0], kWall[1], moved}, kFromAside), 2);
  RoomLocaliser unit(CameraModel{}, {.row_time = 0ns, .map = map_of_wall()});
  for (std::uint64_t number = 1; number < 5; ++number)
    ASSERT_TRUE(unit.process(frame_of(two, number)).rejected.empty());
  const Fix& fix = unit.process(frame_of(all, 5));
  ASSERT_EQ(fix.rejected.size(), 1U);
  EXPECT_EQ(fix.rejected[0], 3);
}

/// In the same place, from one frame to the next.
TEST(RoomLocaliser, NamesAnewASheetThatWasPutInThePlaceOfAnother) {
  test::Viewpoint viewpoint = kFromAside;
  viewpoint.distance_m = 1.4;
  const test::ColourPicture first = coded_picture("KRGBKKRB", viewpoint, 3);
  viewpoint.tilt_rad += 0.06;
  const test::ColourPicture second = coded_picture("RRGKBGKB", viewpoint, 4);
  RoomLocaliser unit(CameraModel{}, {.map = map_of_codes()});
  EXPECT_EQ(unit.process(frame_of(first, 1)).main().id, 11);
  const Fix& fix = unit.process(frame_of(second, 2));
  ASSERT_EQ(fix.landmarks.size(), 1U);
  EXPECT_EQ(fix.main().id, 12);
}

/// By four times the radius of its ring. What was in view tells that, not colours: the second frame has none.
TEST(RoomLocaliser, GoesOnWithASheetThatACameraTurningFastHasElsewhere) {
  test::Viewpoint viewpoint = kFromAside;
  viewpoint.distance_m = 3.5;
  const test::ColourPicture first = coded_picture("KRGBKKRB", viewpoint, 3);
  viewpoint.off_axis_x_rad = 0.0915;
  const test::ColourPicture turned = coded_picture("KRGBKKRB", viewpoint, 4);
  viewpoint.off_axis_x_rad = 0.183;
  const test::ColourPicture goes_on = coded_picture("KRGBKKRB", viewpoint, 5);
  RoomLocaliser unit(CameraModel{}, {.map = map_of_codes()});
  ASSERT_EQ(unit.process(frame_of(first, 1)).landmarks.size(), 1U);
  for (const auto* picture : {&turned.luma, &goes_on.luma}) {
    const Fix& fix = unit.process(frame_of(*picture, picture == &turned.luma ? 2 : 3));
    ASSERT_EQ(fix.landmarks.size(), 1U);
    EXPECT_EQ(fix.main().id, 11);
  }
}

/// At four times the distance it is another sheet's, wherever it is seen.
TEST(RoomLocaliser, DoesNotTakeASheetElsewhereForTheOneThatWasNearer) {
  test::Viewpoint viewpoint = kFromAside;
  viewpoint.distance_m = 1;
  const test::ColourPicture near = coded_picture("KRGBKKRB", viewpoint, 3);
  viewpoint.distance_m = 4;
  viewpoint.off_axis_x_rad = 0.09;
  const test::ColourPicture far = coded_picture("KRGBKKRB", viewpoint, 4);
  RoomLocaliser unit(CameraModel{}, {.map = map_of_codes()});
  ASSERT_EQ(unit.process(frame_of(near, 1)).landmarks.size(), 1U);
  EXPECT_EQ(unit.process(frame_of(far.luma, 2)).reason, Reason::kNotIdentified);
}

TEST(RoomLocaliser, KnowsWhoIsInViewBeyondAChangeOfTheMapAndForgetsWhoIsNotInItAnyMore) {
  test::Viewpoint viewpoint = kFromAside;
  viewpoint.distance_m = 1.4;
  const test::ColourPicture picture = coded_picture("KRGBKKRB", viewpoint, 3);
  RoomMapHandoff maps;
  RoomLocaliser unit(CameraModel{}, {.map = map_of_codes(), .new_maps = &maps});
  ASSERT_EQ(unit.process(frame_of(picture, 1)).main().id, 11);
  const auto change_to = [&](std::vector<MappedLandmark> landmarks) {
    maps.put(std::make_unique<RoomMap>(LandmarkGeometry{}, LandmarkMap(std::move(landmarks)), 0.01));
  };
  // The grey frame can't tell whose it is: the localiser has to remember.
  change_to({mapped({2, 9, 0}, "KKGRRBGB"), mapped({3, 6, 0}), mapped({11, 1, 0}, "KRGBKKRB")});
  const Fix& moved = unit.process(frame_of(picture.luma, 2));
  ASSERT_EQ(moved.landmarks.size(), 1U);
  EXPECT_EQ(moved.main().id, 11);
  const Eigen::Vector3d p_m = moved.main().T_world_camera.translation_m - Eigen::Vector3d(1, 0, 0);
  EXPECT_LT(apart_m(p_m, test::look_at_landmark(viewpoint)), 0.02);
  change_to({mapped({2, 9, 0}, "KKGRRBGB"), mapped({11, 1, 0}, "RRGKBGKB")});
  EXPECT_EQ(unit.process(frame_of(picture.luma, 3)).reason, Reason::kNotIdentified) << "its number is another sheet's";
  change_to({mapped({2, 9, 0}, "KKGRRBGB"), mapped({5, 2, 0}, "KRGBKKRB")});
  const Fix& renamed = unit.process(frame_of(picture, 4));
  ASSERT_EQ(renamed.landmarks.size(), 1U);
  EXPECT_EQ(renamed.main().id, 5);
}

TEST(RoomLocaliser, AllocatesNothing) {
  const test::Picture picture = test::render(scene_of({kWall[0], kWall[1], kWall[2]}, kFromAside), 1);
  const test::ColourPicture coded = coded_picture("KRGBKKRB", kFromAside, 3);
  RoomLocaliser wall(CameraModel{}, {.map = map_of_wall()}), codes(CameraModel{}, {.map = map_of_codes()});
  const test::AllocationGuard guard;
  for (std::uint64_t number = 1; number < 14; ++number) {
    wall.process(frame_of(picture, number));
    codes.process(frame_of(coded, number));
  }
  EXPECT_EQ(guard.allocations(), 0U);
}

/// The first sheet of the wall, changed.
template <typename Change>
test::Picture picture_of_changed(Change change) {
  test::Scene scene = scene_of({kWall[0]}, {.distance_m = 1.2, .tilt_rad = 0.3});
  scene.sheets.front().x_m = scene.sheets.front().z_m = 0;
  change(scene.sheets.front());
  return test::render(scene, 1);
}

TEST(RoomLocaliser, TellsWhatASearchSawThatFoundNothingAndOfThatFrameAlone) {
  RoomLocaliser unit(CameraModel{}, {.map = map_of_wall()});
  EXPECT_FALSE(unit.failed_search()) << "there was no frame yet";
  const test::Picture centreless = picture_of_changed([](test::Sheet& sheet) { sheet.discs.pop_back(); });
  EXPECT_FALSE(unit.process(frame_of(centreless, 1)).found);
  ASSERT_TRUE(unit.failed_search());
  EXPECT_EQ(unit.failed_search()->refusal, Refusal::kNoCentre);
  const test::Picture whole = picture_of_changed([](test::Sheet&) {});
  EXPECT_TRUE(unit.process(frame_of(whole, 2)).found);
  EXPECT_FALSE(unit.failed_search());
}

TEST(RoomLocaliser, SaysOfASheetWhoseDotsAreElsewhereThatItDoesNotFit) {
  // The ring's dots 3 mm further out or in: seen as a landmark, and refuted by its outlines.
  const test::Picture picture = picture_of_changed([](test::Sheet& sheet) {
    const std::array<double, kRingDotCount> out{1, -1, -1, 1, 1, -1, 1, -1};
    for (std::size_t dot = 0; dot < kRingDotCount; ++dot) {
      sheet.discs[dot].x_m *= 1 + 0.0375 * out[dot];
      sheet.discs[dot].z_m *= 1 + 0.0375 * out[dot];
    }
  });
  RoomLocaliser unit(CameraModel{}, {.map = map_of_wall()});
  EXPECT_FALSE(unit.process(frame_of(picture, 1)).found);
  ASSERT_TRUE(unit.failed_search());
  const FailedSearch failed = *unit.failed_search();
  EXPECT_EQ(failed.refusal, Refusal::kPoorFit);
  for (const DotObservation& dot : failed.dots)
    EXPECT_TRUE(std::ranges::any_of(failed.spots, [&](const Blob& spot) {
      return (Eigen::Vector2d(spot.x_px, spot.y_px) - dot.centroid_px).norm() < dot.semi_major_px;
    }));
}

}  // namespace
}  // namespace ninedot
