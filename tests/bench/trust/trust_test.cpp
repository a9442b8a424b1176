// The bench that counts what is wrong must itself count right: made-up verdicts, poses and pictures whose place in the
// table is known, and a few pictures of its own.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "tests/bench/trust/csv.h"
#include "tests/bench/trust/drawn.h"
#include "tests/bench/trust/effects.h"
#include "tests/bench/trust/photographs.h"
#include "tests/bench/trust/run.h"

namespace ninedot::bench {
namespace {

// At 1 m in front, 1-sigma of 1 mm and 1 mrad along each axis.
ClaimedPose claim(double x_m, double turn_rad) {
  const test::CameraPose truth;
  ClaimedPose claimed{truth.position_m, truth.quaternion_wxyz, {}};
  claimed.position_m[0] += x_m;
  // Turned about the camera's own x axis: q * (cos, sin, 0, 0).
  const auto q = truth.quaternion_wxyz;
  const double c = std::cos(turn_rad / 2), s = std::sin(turn_rad / 2);
  claimed.quaternion_wxyz = {q[0] * c - q[1] * s, q[0] * s + q[1] * c, q[2] * c + q[3] * s, q[3] * c - q[2] * s};
  for (std::size_t i = 0; i < 6; ++i) claimed.covariance[7 * i] = 1e-6;
  return claimed;
}

Verdict compared(const ClaimedPose& claimed, bool shown = true) {
  Shot shot;
  if (shown) shot.truth = test::CameraPose{};
  shot.bound_m = 0.0005;
  Verdict verdict;
  compare(claimed, shot, verdict);
  return verdict;
}

test::Scene usual_scene() {
  test::Scene scene;
  scene.camera = test::look_at_landmark({.distance_m = 1.5, .tilt_rad = 0.5});
  test::set_noise(scene.sensor, 2);
  return scene;
}

Strip strip_of(const test::Scene& scene, std::optional<test::CameraPose> truth) {
  Strip strip{"kind", "name", {}};
  strip.shots.push_back({test::render(scene, 1), truth, 0, {}});
  return strip;
}

TEST(Judge, ErrorsAreMeasuredInTheClaimedSigma) {
  const Verdict verdict = compared(claim(0.002, 0.001));
  EXPECT_FALSE(verdict.wrong);
  EXPECT_FALSE(verdict.beyond);
  EXPECT_NEAR(verdict.nees, 4 + 1, 1e-6);
  EXPECT_NEAR(verdict.error_m, 0.002, 1e-12);
  EXPECT_NEAR(verdict.turn_rad, 0.001, 1e-9);
  EXPECT_NEAR(verdict.error_over_bound, 4, 1e-9);
}

TEST(Judge, WrongIsBeyondSixSigmaAndOnePercent) {
  // 6 sigma of three axes are 10.4 mm and 10.4 mrad, 1 % are 10 mm and 10 mrad.
  EXPECT_FALSE(compared(claim(0.0103, 0)).wrong);
  EXPECT_TRUE(compared(claim(0.0105, 0)).wrong);
  EXPECT_FALSE(compared(claim(0, 0.0103)).wrong);
  EXPECT_TRUE(compared(claim(0, 0.0105)).wrong);
  ClaimedPose sure = claim(0.009, 0);
  for (double& element : sure.covariance) element /= 100;
  EXPECT_TRUE(compared(sure).beyond);
  EXPECT_FALSE(compared(sure).wrong);
}

TEST(Judge, NoNumberAndNoLandmarkAreWrong) {
  EXPECT_TRUE(compared(claim(std::numeric_limits<double>::quiet_NaN(), 0)).wrong);
  EXPECT_TRUE(compared(claim(0, 0), false).wrong);
}

TEST(Judge, ALandmarkThatIsThereIsValidAndRight) {
  const test::Scene scene = usual_scene();
  const Verdict verdict = judge(strip_of(scene, scene.camera)).front();
  EXPECT_TRUE(verdict.shown && verdict.found && verdict.valid);
  EXPECT_FALSE(verdict.wrong);
  EXPECT_GT(verdict.nees, 0);
  EXPECT_GT(verdict.work_ms, 0);
  const Verdict coloured = judge(strip_of(scene, scene.camera), CameraKind::kColour).front();
  EXPECT_TRUE(coloured.valid && !coloured.wrong);
  EXPECT_NE(coloured.error_m, verdict.error_m) << "it is fitted otherwise";
}

TEST(Judge, ALandmarkWhereNoneShouldBeIsWrongAndValid) {
  const Verdict verdict = judge(strip_of(usual_scene(), std::nullopt)).front();
  EXPECT_FALSE(verdict.shown);
  EXPECT_TRUE(verdict.found && verdict.valid && verdict.wrong);
}

TEST(Judge, ALandmarkElsewhereIsWrongAndValid) {
  const test::Scene scene = usual_scene();
  const auto elsewhere = test::look_at_landmark({.distance_m = 1.5, .tilt_rad = 0.5, .azimuth_rad = 0.1});
  EXPECT_TRUE(judge(strip_of(scene, elsewhere)).front().wrong);
}

TEST(Tally, CountsWhatTheVerdictsSay) {
  Tally tally;
  tally.add({true, true, true, false, false, 6, 0.001, 0, 2, 5});
  tally.add({true, true, true, false, true, 18, 0.001, 0, 3, 7});
  tally.add({true, true, true, true, true, 0, 1, 0, 0, 6});
  tally.add({true, true, false, false, false, 0, 0, 0, 0, 1});
  tally.add({false, false, false, false, false, 0, 0, 0, 0, 1});
  Tally twice = tally;
  twice.add(tally);
  EXPECT_EQ(twice.pictures, 10);
  EXPECT_EQ(twice.shown, 8);
  EXPECT_EQ(twice.found, 8);
  EXPECT_EQ(twice.valid, 6);
  EXPECT_EQ(twice.wrong, 2);
  EXPECT_EQ(twice.beyond, 4);
  EXPECT_NEAR(twice.error_over_sigma(), std::sqrt(2.0), 1e-12);
  EXPECT_EQ(twice.median_over_bound(), 3);
  EXPECT_EQ(twice.slowest_ms, 7);
}

TEST(Tally, OneFalseLandmarkIsTooMuchAndOneOfAHundredViewsIsNot) {
  Tally tally;
  tally.pictures = 100, tally.wrong = 1;
  EXPECT_TRUE(is_over_limit({"Photographs", "a"}, tally));
  EXPECT_TRUE(is_over_limit({"Near misses", "a"}, tally));
  EXPECT_FALSE(is_over_limit({"Views", "a"}, tally));
  EXPECT_FALSE(is_over_limit({"Camera effects", "a"}, tally));
  tally.wrong = 2;
  EXPECT_TRUE(is_over_limit({"Views", "a"}, tally));
  EXPECT_TRUE(is_over_limit({"Camera effects", "a"}, tally));
}

TEST(Tally, EveryGroupHasALimit) {
  std::vector<Kind> kinds = drawn_jobs([](const Kind&) { return true; }, 1, 1).kinds;
  for (const Kind& kind : photograph_kinds()) kinds.push_back(kind);
  Tally bad;
  bad.pictures = bad.wrong = 100;
  for (const Kind& kind : kinds) EXPECT_TRUE(is_over_limit(kind, bad)) << kind.name;
}

TEST(Csv, ReadsBackWhatItWrote) {
  const std::string path = testing::TempDir() + "trust_test.csv";
  const Strip strip{"tilt, steep", "a \"strip\"", {}};
  {
    std::ofstream file(path);
    file << kCsvHeader << csv_line(strip, 3, {true, true, true, true, false, 0, 0.25, 0, 0, 5});
  }
  Tallies tallies;
  ASSERT_TRUE(add_csv(path, tallies));
  EXPECT_EQ(tallies["tilt, steep"].pictures, 1);
  EXPECT_EQ(tallies["tilt, steep"].wrong, 1);
  EXPECT_EQ(tallies["tilt, steep"].beyond, 0);
  std::ofstream(path) << kCsvHeader << "something else\n";
  EXPECT_FALSE(add_csv(path, tallies));
}

TEST(Photographs, TwinsAreInOneHalfAndHalvesAreHalves) {
  EXPECT_EQ(half_of("sea-d.jpg"), half_of("sea-l.jpg"));
  EXPECT_EQ(half_of("Elephants_3840x2160.png"), half_of("Elephants_5640x3172.png"));
  int held = 0;
  for (char a = 'a'; a <= 'z'; ++a)
    for (char b = 'a'; b <= 'z'; ++b) held += half_of(std::string{a, b, 'q'} + ".jpg") == Half::kHeld ? 1 : 0;
  EXPECT_NEAR(held, 26 * 13, 60);
}

TEST(Photographs, WindowsAreCutAtThreeScales) {
  const std::filesystem::path folder = std::filesystem::path(testing::TempDir()) / "trust_photographs";
  std::filesystem::create_directories(folder);
  const test::Picture picture = test::render(usual_scene(), 1);
  std::ofstream file(folder / "sheet.pgm", std::ios::binary);
  file << "P5\n640 480\n255\n";
  for (const std::uint8_t level : picture.pixels) file.put(static_cast<char>(level));
  file.close();
  const Tallies tallies = run_jobs(photograph_jobs(folder, Half::kBoth), {});
  ASSERT_EQ(tallies.size(), 4U);
  for (const auto& [kind, tally] : tallies) EXPECT_EQ(tally.pictures, kind.ends_with("room") ? 3 : 1) << kind;
  // It shows a landmark, which no photograph should.
  EXPECT_EQ(tallies.at("photographs, full scale").wrong, 1);
  EXPECT_GE(tallies.at("photographs, half scale, in a room").wrong, 1);
}

TEST(Drawn, EveryKindGivesThePicturesAskedFor) {
  const auto wanted = [](const Kind& kind) {
    return kind.name.starts_with("ring of") || kind.name == "even light, 0.5 to 6 m" ||
           kind.name == "low light, track" || (kind.group == "Camera effects" && !kind.name.ends_with("track"));
  };
  const DrawnJobs drawn = drawn_jobs(wanted, 1, 7);
  const Tallies tallies = run_jobs(drawn.jobs, {.threads = 2});
  EXPECT_EQ(tallies.size(), drawn.kinds.size());
  for (const Kind& kind : drawn.kinds) {
    ASSERT_TRUE(tallies.contains(kind.name)) << kind.name;
    const Tally& tally = tallies.at(kind.name);
    const int pictures = kind.name.ends_with("track") ? kTrackFrames : 1;
    EXPECT_EQ(tally.pictures, pictures) << kind.name;
    EXPECT_EQ(tally.shown, kind.group == "Near misses" ? 0 : pictures) << kind.name;
  }
  EXPECT_EQ(tallies.at("no effect").valid, 1);
  EXPECT_EQ(tallies.at("no effect").wrong, 0);
  const std::string page = trust_page(drawn.kinds, tallies, {1, "trust"});
  for (const Kind& kind : drawn.kinds) EXPECT_NE(page.find("| " + kind.name + " |"), std::string::npos) << kind.name;
}

TEST(Drawn, TheSameSeedGivesTheSamePicturesWhateverElseIsDrawn) {
  const auto picture_of = [](std::string_view group, std::uint64_t seed) {
    std::vector<std::uint8_t> pixels;
    const auto wanted = [&](const Kind& kind) { return kind.name == "ring of 7" || kind.group == group; };
    for (const Job& job : drawn_jobs(wanted, 1, seed).jobs)
      if (pixels.empty())
        job([&](const Strip& strip) {
          if (strip.kind == "ring of 7") pixels = strip.shots[0].picture.pixels;
        });
    return pixels;
  };
  const auto pixels = picture_of("", 1);
  ASSERT_FALSE(pixels.empty());
  EXPECT_EQ(pixels, picture_of("Views", 1));
  EXPECT_NE(pixels, picture_of("", 2));
}

TEST(Effects, FiltersLeaveAnEvenPictureAsItIs) {
  const test::Picture even{64, 48, std::vector<std::uint8_t>(64 * 48, 100)};
  EXPECT_EQ(through_jpeg(even, 75).pixels, even.pixels);
  EXPECT_EQ(sharpened(even, 1.5).pixels, even.pixels);
  EXPECT_EQ(median_of_nine(even).pixels, even.pixels);
  EXPECT_EQ(bilateral(even, 1.5, 10).pixels, even.pixels);
}

TEST(Effects, EachChangesThePicture) {
  MovingView view;
  test::Random random(3);
  view = usual_view(random);
  const auto shots = shoot_through(effects(), view, 1, 5);
  for (std::size_t i = 1; i < shots.size(); ++i)
    EXPECT_NE(shots[i][0].picture.pixels, shots[0][0].picture.pixels) << effects()[i].name;
}

}  // namespace
}  // namespace ninedot::bench
