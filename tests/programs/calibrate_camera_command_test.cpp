// `ninedot calibrate camera` as it is typed, on rendered pictures through a lens that is known.
#include <gtest/gtest.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "base/startup_error.h"
#include "calibrate_camera/lens_uncertainty.h"
#include "calibrate_camera/sufficiency.h"
#include "drivers/picture/picture_file.h"
#include "programs/assembly/input_files.h"
#include "programs/commands/collect_views.h"
#include "programs/commands/commands.h"
#include "programs/commands/live_views.h"
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

/// Poses of which each brings something that is wanted, until nothing is.
std::vector<test::Picture> wanted_pictures() {
  const std::vector<PlaneDisc> discs = discs_of(LandmarkGeometry{});
  std::vector<SheetView> views;
  std::vector<test::Picture> made;
  for (std::uint64_t i = 0; !wanted_views(tally_of(views, discs, 640, 480)).empty(); ++i) {
    const test::CameraPose pose = test::held_pose(kTruth, {}, 78, i);
    views.push_back(test::perfect_view(kTruth, pose, discs, 0, i));
    const bool is_whole = views.back().seen.size() == kDotCount;
    if (is_whole) made.push_back(test::held_picture(kTruth, pose, test::nine_dot_sheet(), i));
    if (!is_whole) views.pop_back();
  }
  return made;
}

class CalibrateCameraLive : public CalibrateCameraCommandLine {
 protected:
  /// Each picture three times, as a camera sees a sheet that is held still.
  std::string config_of_camera(const std::vector<test::Picture>& pictures) {
    std::vector<test::Picture> frames;
    for (const test::Picture& picture : pictures) frames.insert(frames.end(), 3, picture);
    record("camera", frames);
    return config("[camera]\nsource = \"recording\"\ndevice = \"" + path("camera") + "\"\n");
  }
  std::string config(const std::string& text) {
    std::ofstream(folder_ / "c.toml") << text;
    return path("c.toml");
  }
};

TEST_F(CalibrateCameraLive, EndsByItselfWhenThereIsEnough) {
  std::vector<test::Picture> pictures = wanted_pictures();
  pictures.insert(pictures.end(), 20, pictures.back());
  const test::TypedOutcome outcome = type({"--config", config_of_camera(pictures), "--keep", path("out/kept")});
  EXPECT_EQ(outcome.status, ExitStatus::kSuccess) << outcome.line;
  EXPECT_NE(outcome.said.find("views; wanted: nothing\n"), std::string::npos) << outcome.said;
  EXPECT_NE(outcome.said.find("the views are kept in " + path("out/kept")), std::string::npos);
  EXPECT_LT(direction_differences(kTruth, read_camera_file(path("out/camera.yaml"))).median_px(), 0.04);
  const auto kept = std::distance(fs::directory_iterator(folder_ / "out/kept/frames"), {});
  EXPECT_GE(kept, 30);
  EXPECT_LE(kept, static_cast<std::ptrdiff_t>(pictures.size()));
}

TEST_F(CalibrateCameraLive, TellsAnotherProgramLineByLine) {
  testing::internal::CaptureStdout();
  const std::vector<test::Picture> few(pictures().begin(), pictures().begin() + 3);
  const test::TypedOutcome outcome = type({"--config", config_of_camera(few), "--progress", "json"});
  const std::string said = testing::internal::GetCapturedStdout();
  EXPECT_EQ(outcome.status, ExitStatus::kWorkFailed);
  const std::string first = said.substr(0, said.find('\n'));
  EXPECT_TRUE(first.starts_with(R"({"state":"gathering","views":0,"wanted":["upper left",)")) << first;
  EXPECT_NE(first.find(R"("looked":"none","part":null,"sheet":[],"ghost":{"meets":["upper left")"), std::string::npos)
      << first;
  EXPECT_NE(said.find(R"("views":2,)"), std::string::npos) << said;
  EXPECT_NE(said.find(R"("looked":"taken","part":)"), std::string::npos) << said;
  EXPECT_NE(said.find(R"({"state":"failed","why":"two views are too few)"), std::string::npos) << said;
  EXPECT_TRUE(said.ends_with("}\n"));
  test::expect_refusal(test::type_command(add_calibrate_command,
                                          {"calibrate", "camera", path("camera"), "--progress", "json", "--out", "-"}),
                       ExitStatus::kWrongUsage, "would both write to standard output");
  test::expect_refusal(type({"--config", config_of_camera(few), "--progress", "json", "--picture", "-"}),
                       ExitStatus::kWrongUsage, "--progress and --picture - would both write to standard output");
}

TEST_F(CalibrateCameraLive, WatchesNoServiceThatDoesNotRun) {
  const std::string camera = "[camera]\nsource = \"v4l2\"\ndevice = \"/dev/no-camera\"\n";
  fails(ExitStatus::kWorkFailed, {"--tap", "--config", config(camera)}, "write `enabled = true` under [tap]");
  fails(ExitStatus::kWorkFailed,
        {"--tap", "--config", config(camera + "[tap]\nenabled = true\npath = \"" + path("tap") + "\"\n")}, path("tap"));
  record("walk", {pictures().front()});
  fails(ExitStatus::kWrongUsage, {path("walk"), "--tap"}, "--tap watches a running service");
}

TEST_F(CalibrateCameraLive, SaysWhatIsMissingWhenTheSourceEndsAndKeepsWhatItHas) {
  const std::vector<test::Picture> few(pictures().begin(), pictures().begin() + 4);
  const test::TypedOutcome outcome = type({"--config", config_of_camera(few)});
  test::expect_refusal(outcome, ExitStatus::kWorkFailed, "views are too few");
  test::expect_refusal(outcome, ExitStatus::kWorkFailed,
                       "; the views until then are kept in " + path("out/camera-views"));
  EXPECT_GE(std::distance(fs::directory_iterator(folder_ / "out/camera-views/frames"), {}), 3);
  EXPECT_FALSE(fs::exists(folder_ / "out/camera.yaml"));
  test::expect_refusal(type({path("out/camera-views")}), ExitStatus::kWorkFailed, "views are too few");
}

TEST_F(CalibrateCameraLive, RefusesWhatItCanNotStartFrom) {
  fails(ExitStatus::kWrongUsage, {}, "give recordings of a sheet, or --config FILE");
  fails(ExitStatus::kWrongUsage, {"--config", config("[pose]\nsolver = \"full\"\n")}, "camera.device is missing");
  fails(ExitStatus::kWrongUsage, {"--config", config("[camera]\nsource = \"v4l2\"\ndevice = \"/dev/no-camera\"\n")},
        "/dev/no-camera: no such camera");
  record("walk", {pictures().front()});
  fails(ExitStatus::kWrongUsage, {path("walk"), "--keep", path("out/kept")}, "--keep is for a camera's views");
  fails(ExitStatus::kWrongUsage, {path("walk"), "--config", config(""), "--grid", "9x7@25"}, "need no --config");
  const std::string camera = config_of_camera({pictures().front()});
  fails(ExitStatus::kWrongUsage, {"--config", camera, "--keep", path("walk")}, "not empty");
  const test::Picture grey{640, 480, std::vector<std::uint8_t>(640 * 480, 128)};
  fs::remove_all(folder_ / "camera");
  fails(ExitStatus::kWorkFailed, {"--config", config_of_camera({grey})}, "no landmark in any of 3 pictures");
}

/// A camera that gives some frames and is gone.
class VanishingCamera final : public FrameSource {
 public:
  explicit VanishingCamera(const test::Picture& picture) : picture_(picture) {}
  Result<FrameLease> next(MonoTime /*deadline*/) noexcept override {
    if (++asked_ > 5) return tl::unexpected(Error{Errc::kCameraLost, 0, "the camera is gone"});
    FrameLease lease;
    lease.frame.luma = picture_.view();
    return lease;
  }

 private:
  const test::Picture& picture_;
  int asked_ = 0;
};

TEST_F(CalibrateCameraLive, TellsThatTheCameraIsGoneAndKeepsWhatItHas) {
  OpenedSource source;
  source.frames = std::make_unique<VanishingCamera>(pictures().front());
  source.describe_failure = [](const FrameSource&) { return std::string("the camera is gone"); };
  CalibrationTarget target;
  target.discs = discs_of(target.landmark);
  LiveViews live(source, target,
                 {640, 480, path("out/kept"), [] { return false; }, [](auto) { return std::optional<CameraModel>(); }});
  try {
    live.gather();
    FAIL() << "a camera that is gone gives no views";
  } catch (const StartupError& error) {
    EXPECT_EQ(error.status, ExitStatus::kWorkFailed);
    EXPECT_EQ(error.what(), "the camera is gone; the views until then are kept in " + path("out/kept"));
  }
  EXPECT_TRUE(fs::exists(folder_ / "out/kept/frames/000000.png"));
}

}  // namespace
}  // namespace ninedot
