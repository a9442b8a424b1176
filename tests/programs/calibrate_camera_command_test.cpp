// `ninedot calibrate camera` as it is typed, on rendered pictures through a lens that is known.
#include <gtest/gtest.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "base/startup_error.h"
#include "calibrate_camera/lens_uncertainty.h"
#include "drivers/picture/picture_file.h"
#include "programs/assembly/input_files.h"
#include "programs/commands/collect_views.h"
#include "programs/commands/commands.h"
#include "tests/calibrate_camera/lens_scene.h"
#include "tests/programs/typed_command.h"
#include "tests/support/random.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

const CameraModel kTruth{
    640, 480, 612.3, 611.1, 323.1, 236.4, DistortionModel::kPlumbBob, {-0.21, 0.06, 0.0007, -0.0004, 0.01}};
constexpr std::size_t kPictures = 24;

/// Rendered once: the landmark from many sides.
const std::vector<test::Picture>& pictures() {
  static const std::vector<test::Picture> all = [] {
    std::vector<test::Picture> made;
    for (std::uint64_t i = 0; i < kPictures; ++i)
      made.push_back(test::held_picture(kTruth, test::held_pose(kTruth, {}, 77, i), test::nine_dot_sheet(), i));
    return made;
  }();
  return all;
}

std::string text_of(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

class CalibrateCameraCommandLine : public testing::Test {
 protected:
  CalibrateCameraCommandLine()
      : folder_(fs::temp_directory_path() / ("ninedot_calibrate_camera_" + std::to_string(::getpid()))) {
    fs::create_directories(folder_ / "out");
  }
  ~CalibrateCameraCommandLine() override { fs::remove_all(folder_); }

  void record(const char* name, const std::vector<test::Picture>& frames) {
    fs::create_directories(folder_ / name / "frames");
    for (std::size_t i = 0; i < frames.size(); ++i) {
      char file[32];
      std::snprintf(file, sizeof file, "%06zu.png", i);
      ASSERT_TRUE(write_png_grey((folder_ / name / "frames" / file).string(), frames[i].view()));
    }
  }

  /// `ninedot calibrate camera WORDS --out out/camera.yaml`
  test::TypedOutcome type(std::vector<std::string> words) {
    words.insert(words.begin(), {"calibrate", "camera"});
    words.insert(words.end(), {"--out", path("out/camera.yaml")});
    return test::type_command(add_calibrate_command, std::move(words));
  }
  void run(const std::vector<std::string>& words) {
    const test::TypedOutcome outcome = type(words);
    EXPECT_EQ(outcome.status, ExitStatus::kSuccess) << outcome.line;
  }
  void fails(ExitStatus status, const std::vector<std::string>& words, const std::string& what) {
    test::expect_refusal(type(words), status, what);
    EXPECT_TRUE(fs::is_empty(folder_ / "out")) << "something was left behind";
  }

  std::string path(const char* name) const { return (folder_ / name).string(); }

  const fs::path folder_;
};

TEST_F(CalibrateCameraCommandLine, FindsTheLensWhateverTheRecordingSaysOfIt) {
  record("walk", pictures());
  run({path("walk"), "--lens", "4 mm \"C\""});
  const CameraModel found = read_camera_file(path("out/camera.yaml"));
  EXPECT_LT(direction_differences(kTruth, found).median_px(), 0.06);
  EXPECT_EQ(found.model, DistortionModel::kPlumbBob);
  const std::string text = text_of(path("out/camera.yaml"));
  for (const char* part : {"# plumb_bob is the simplest", "\ncalibration:", "\n  lens: \"4 mm \\\"C\\\"\"",
                           "\n  direction_sigma_px: 0.", "\n    rows: 9\n    cols: 9\n    data: ["})
    EXPECT_NE(text.find(part), std::string::npos) << part;
  EXPECT_NE(text_of(path("out/camera.svg")).find("Expected error of directions"), std::string::npos);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "out"), {}), 2);

  // The same again beside a camera.yaml that is far off, and one that is none.
  for (const char* own :
       {"image_width: 640\nimage_height: 480\ncamera_matrix:\n  data: [1500, 0, 100, 0, 1500, 400, 0, 0, "
        "1]\ndistortion_model: plumb_bob\ndistortion_coefficients:\n  data: [0.5, 0, 0, 0, 0]\n",
        "not: [a calibration"}) {
    std::ofstream(folder_ / "walk" / "camera.yaml") << own;
    run({path("walk")});
    EXPECT_LT(direction_differences(found, read_camera_file(path("out/camera.yaml"))).max_px(), 0.02);
  }
}

TEST_F(CalibrateCameraCommandLine, GivesTheSameFileForTheSameRecordingAndTakesSeveral) {
  const auto middle = pictures().begin() + kPictures / 2;
  record("first", {pictures().begin(), middle});
  record("second", {middle, pictures().end()});
  run({path("first"), path("second"), "--model", "plumb_bob", "--picture", path("out/picture.svg")});
  const std::string text = text_of(path("out/camera.yaml"));
  EXPECT_TRUE(fs::exists(path("out/picture.svg")));
  EXPECT_NE(text.find("plumb_bob, as --model asks"), std::string::npos);
  run({path("first"), path("second"), "--model", "plumb_bob"});
  EXPECT_EQ(text, text_of(path("out/camera.yaml")));
}

TEST_F(CalibrateCameraCommandLine, SaysWhatIsMissingInARecording) {
  record("few", {pictures().begin(), pictures().begin() + 5});
  fails(ExitStatus::kWorkFailed, {path("few")}, "views are too few");
  record("still", std::vector<test::Picture>(12, pictures().front()));
  fails(ExitStatus::kWorkFailed, {path("still")}, "all 12 pictures show the sheet in one place");
  test::Picture grey{640, 480, std::vector<std::uint8_t>(640 * 480, 128)};
  record("without", {3, grey});
  fails(ExitStatus::kWorkFailed, {path("without")}, "no landmark in any of 3 pictures");
  fails(ExitStatus::kWorkFailed, {path("few"), "--grid", "9x7@25"}, "no grid of 9x7 dots in any of 5 pictures");

  // Only in the upper half, on the right.
  CameraModel part = kTruth;
  part.cx_px += 110, part.cy_px -= 70;
  test::Holding there;
  there.off_centre_share = 0.2, there.min_distance_m = 0.7, there.max_distance_m = 1.0;
  std::vector<test::Picture> frames;
  for (std::uint64_t i = 0; i < 16; ++i)
    frames.push_back(test::held_picture(kTruth, test::held_pose(part, there, 5, i), test::nine_dot_sheet(), i));
  record("part", frames);
  fails(ExitStatus::kWorkFailed, {path("part")}, "no views in the ");
  fails(ExitStatus::kWorkFailed, {path("part")}, "in the lower left");
}

TEST_F(CalibrateCameraCommandLine, SaysThatFrontalViewsLeaveTheFocalLengthOpen) {
  std::vector<test::Picture> frames;
  for (std::uint64_t i = 0; i < 40; ++i)
    frames.push_back(test::held_picture(kTruth, test::frontal_pose(6, i), test::nine_dot_sheet(), i));
  record("frontal", frames);
  fails(ExitStatus::kWorkFailed, {path("frontal"), "--model", "plumb_bob"}, "tilt the sheet");
}

TEST_F(CalibrateCameraCommandLine, RefusesWhatItCanNotStartFrom) {
  record("walk", {pictures().begin(), pictures().begin() + 2});
  test::Picture small{320, 240, std::vector<std::uint8_t>(320 * 240, 128)};
  record("small", {small});
  fails(ExitStatus::kWrongUsage, {path("walk"), path("small")}, "its pictures are 320x240");
  record("mixed", {pictures()[0], small});
  fails(ExitStatus::kWrongUsage, {path("mixed")}, "calibrate each size by itself");
  fails(ExitStatus::kWrongUsage, {path("nowhere")}, "nowhere");
  fails(ExitStatus::kWrongUsage, {path("walk"), "--grid", "9x7"}, "--grid 9x7: give COLUMNSxROWS@PITCH");
  fails(ExitStatus::kWorkFailed, {path("walk"), "--picture", path("nowhere/picture.svg")}, "nowhere/picture.svg");
  std::ofstream(folder_ / "walk" / "frames" / "000001.png") << "no picture";
  fails(ExitStatus::kWorkFailed, {path("walk")}, "repair the recording");
  EXPECT_THROW(run({path("walk"), "--model", "pinhole"}), CLI::ParseError);
}

TEST_F(CalibrateCameraCommandLine, EndsAtCtrlCAndWritesNothingThatIsHalf) {
  record("walk", pictures());
  sigset_t set;
  sigemptyset(&set);
  sigaddset(&set, SIGINT);
  ASSERT_EQ(pthread_sigmask(SIG_BLOCK, &set, nullptr), 0);
  ASSERT_EQ(::raise(SIGINT), 0);  // waits until somebody takes it
  fails(ExitStatus::kWorkFailed, {path("walk")}, "stopped");
}

TEST_F(CalibrateCameraCommandLine, KeepsWhatItHasWhenItsSearchIsStopped) {
  record("walk", pictures());
  LandmarkFinder finder(usual_camera(640, 480), {});
  int asked = 0;
  const CollectedViews views = collect_views(check_recordings({path("walk")}), finder, discs_of(LandmarkGeometry{}),
                                             [&](const std::string&) { return ++asked <= 12; });
  EXPECT_GE(views.pictures, 5U);  // asked while it waits for the reader too
  EXPECT_LE(views.pictures, 12U);
  EXPECT_GE(views.views.views().size() + 4, views.pictures);
}

}  // namespace
}  // namespace ninedot
