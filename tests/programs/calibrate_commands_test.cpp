// `ninedot calibrate ...` as it is typed, on rendered pictures with exact truth.
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "base/startup_error.h"
#include "base/units.h"
#include "calibrate/camera_file.h"
#include "config/config_checks.h"
#include "drivers/picture/picture_file.h"
#include "programs/commands/commands.h"
#include "tests/programs/typed_command.h"
#include "tests/recording/temporary_recording.h"
#include "tests/support/renderer.h"
#include "tests/support/room_renderer.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

class Calibrate : public testing::Test {
 protected:
  static test::TypedOutcome run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "calibrate");
    return test::type_command(add_calibrate_command, std::move(arguments));
  }

  void add_picture(const test::Picture& picture) {
    ASSERT_TRUE(write_png_grey(fmt::format("{}/frames/{:06}.png", folder_.path(), count_), picture.view()));
    ++count_;
  }
  void write_camera(const test::Lens& lens) {
    CameraModel camera;
    camera.width_px = lens.width_px, camera.height_px = lens.height_px;
    camera.fx_px = lens.fx_px, camera.fy_px = lens.fy_px, camera.cx_px = lens.cx_px, camera.cy_px = lens.cy_px;
    folder_.write("camera.yaml", format_camera(camera, "rendered"));
  }
  std::string out() const { return folder_.path() + "/out.toml"; }
  Config written() const {
    std::ifstream file(out());
    ConfigProblems problems;
    const Config config = parse_config(std::string(std::istreambuf_iterator<char>(file), {}), "out.toml", problems);
    EXPECT_TRUE(problems.list.empty());
    return config;
  }

  TemporaryRecording folder_{0};
  int count_ = 0;
};

TEST_F(Calibrate, EllipseFindsTheFactorOfTheLensThatThePicturesWereTakenWith) {
  // The camera's own file is off by 2 %: the shots make up for it, which is what the paper calibrates for.
  test::Lens lens;
  lens.fx_px = lens.fy_px = 720;
  const double distances_m[] = {0.8, 1.0, 1.3, 1.7, 2.2};
  std::string csv = "frame,distance_mm,centred_frame\n";
  const auto shoot = [&](const test::Viewpoint& viewpoint, const std::string& more) {
    test::Scene scene;
    scene.lens = lens;
    scene.camera = test::look_at_landmark(viewpoint);
    set_noise(scene.sensor, 1.5);
    csv += fmt::format("{},{}{}\n", count_, 1000 * viewpoint.distance_m, more);
    add_picture(test::render(scene, static_cast<std::uint64_t>(count_)));
  };
  for (const double distance_m : distances_m) shoot({.distance_m = distance_m, .tilt_rad = 0.3}, "");
  shoot({.distance_m = 1.3, .tilt_rad = 0.3, .off_axis_x_rad = 0.25}, ",2");
  test::Lens wrong = lens;
  wrong.fx_px = wrong.fy_px = 1.02 * lens.fx_px;
  write_camera(wrong);
  folder_.write("shots.csv", csv);
  const test::TypedOutcome outcome = run({"ellipse", folder_.path(), "--shots", folder_.path() + "/shots.csv",
                                          "--focal-length-mm", "5.4", "--out", out()});
  ASSERT_EQ(outcome.status, ExitStatus::kSuccess) << outcome.line;
  const EllipseConfig e = written().ellipse;
  EXPECT_NEAR(e.kmm_mm_per_px, 5.4 / lens.fx_px, 0.004 * 5.4 / lens.fx_px);
  // F / Kmm is what the file is off by.
  const double image_mm = 1300 + wrong.fx_px * e.kmm_mm_per_px;
  EXPECT_NEAR((e.p1 + e.p2 * std::pow(image_mm, e.p3)) / e.kmm_mm_per_px, 1.02, 0.004);
  EXPECT_NE(e.cu, 0);
  EXPECT_EQ(e.cv, 0) << "no shot is off along v";
}

TEST_F(Calibrate, EllipseRefusesWithOneLineAndLeavesNothingBehind) {
  for (int i = 0; i < 2; ++i) {
    test::Scene scene;
    scene.lens = {.width_px = 320, .height_px = 240, .fx_px = 360, .fy_px = 360, .cx_px = 159.5, .cy_px = 119.5};
    if (i == 1) scene.sheets.clear();
    write_camera(scene.lens);
    add_picture(test::render(scene, 1));
  }
  const auto refusal = [&](const std::vector<std::string>& more, ExitStatus status) {
    std::vector<std::string> arguments{"ellipse", folder_.path(), "--focal-length-mm", "5.4", "--out", out()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const test::TypedOutcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, status) << outcome.line;
    EXPECT_FALSE(fs::exists(out()));
    return outcome.line;
  };
  EXPECT_NE(refusal({}, ExitStatus::kWrongUsage).find("no shots"), std::string::npos);
  EXPECT_NE(refusal({"--shot", "0"}, ExitStatus::kWrongUsage).find("--shot 0: write a frame's number"),
            std::string::npos);
  EXPECT_NE(refusal({"--shot", "0:1000", "--shot", "0:900"}, ExitStatus::kWrongUsage).find("twice"), std::string::npos);
  EXPECT_NE(refusal({"--shot", "7:1000"}, ExitStatus::kWrongUsage).find("has no frame 7"), std::string::npos);
  EXPECT_NE(refusal({"--shot", "1:1000"}, ExitStatus::kWorkFailed).find("frame 1 shows no landmark"),
            std::string::npos);
  EXPECT_NE(refusal({"--shot", "0:1000"}, ExitStatus::kWorkFailed).find("at 1 distances; 4 are needed"),
            std::string::npos);
  folder_.write("shots.csv", "frame,distance_mm\n0,1000\n1,far\n");
  EXPECT_NE(refusal({"--shots", folder_.path() + "/shots.csv"}, ExitStatus::kWrongUsage).find("shots.csv:3: write"),
            std::string::npos);
  EXPECT_EQ(run({"ellipse", folder_.path() + "/none", "--shot", "0:1000", "--focal-length-mm", "5"}).status,
            ExitStatus::kWrongUsage);
  write_camera({});
  EXPECT_NE(refusal({"--shot", "0:1000"}, ExitStatus::kWrongUsage).find("its pictures are 320x240"), std::string::npos);
}

/// A camera that a hand swings before one landmark on a wall, 0.45 m away.
test::CameraPose swung(double time_s, double swing) {
  const double phase = 2 * M_PI * 0.8 * time_s;
  test::CameraPose pose = test::look_at_landmark({.distance_m = 0.45 + 0.03 * swing * std::sin(0.7 * phase),
                                                  .tilt_rad = 0.45 + 0.15 * swing * std::sin(phase),
                                                  .azimuth_rad = 0.4 + 0.3 * swing * std::cos(1.2 * phase),
                                                  .off_axis_x_rad = 0.12 * swing * std::sin(1.1 * phase),
                                                  .off_axis_y_rad = 0.10 * swing * std::cos(0.9 * phase)});
  return pose;
}

class CalibrateShutter : public Calibrate {
 protected:
  void film(double row_time_s, double swing, int frames) {
    const test::Lens lens{
        .width_px = 320, .height_px = 240, .fx_px = 330, .fy_px = 330, .cx_px = 159.5, .cy_px = 119.5};
    write_camera(lens);
    test::Room room;
    room.low_m = {-30, 0, -30}, room.high_m = {30, 30, 30};
    room.wall = {0.35, 0, 0.12, 1};
    room.landmarks = {{test::RoomSide::kLowY, 0, 0, test::inks_of_code("KKKKKKKK"), {0.9, 0.9, 0.9}}};
    test::Sensor sensor;
    set_noise(sensor, 1.5);
    const test::RoomRenderer renderer(room, lens, sensor);
    std::string csv = "frame,timestamp_ns\n";
    for (int i = 0; i < frames; ++i) {
      const double at_s = i / 35.0;
      const auto exposure = renderer.expose([&](double after_s) { return swung(at_s + after_s, swing); },
                                            {.exposure_s = 1e-3, .row_time_s = row_time_s, .sub_exposures = 2});
      csv += fmt::format("{},{}\n", i, std::llround(1e9 * at_s) + 1'000'000'000);
      add_picture(read_out(exposure, sensor, test::ChromaLayout::k444, static_cast<std::uint64_t>(i)).luma);
    }
    folder_.write("frames.csv", csv);
  }
  test::TypedOutcome calibrate() { return run({"rolling-shutter", folder_.path(), "--out", out()}); }
  /// As the file's comment says it.
  double sigma_us() const {
    std::ifstream file(out());
    const std::string text(std::istreambuf_iterator<char>(file), {});
    const std::size_t at = text.find("1-sigma ");
    EXPECT_NE(at, std::string::npos) << text;
    return std::stod(text.substr(at + 8));
  }
  void expect_row_time_of_80_us() {
    const test::TypedOutcome outcome = calibrate();
    ASSERT_EQ(outcome.status, ExitStatus::kSuccess) << outcome.line;
    const double sigma = sigma_us();
    EXPECT_LT(sigma, 0.01 * 80);
    EXPECT_NEAR(written().camera.row_time_us.value_or(0), 80, 2.5 * sigma);
  }
};

TEST_F(CalibrateShutter, FindsTheRowTimeOfAFilm) {
  film(80e-6, 1, 50);
  expect_row_time_of_80_us();
}

// What the first look, which takes all rows for one instant, leaves of the outlines made it say of hands that moved by
// 280 to 590 px/s that they were too slow.
TEST_F(CalibrateShutter, IsNoStricterBeforeItKnowsTheRows) {
  film(80e-6, 1.5, 50);
  expect_row_time_of_80_us();
}

TEST_F(CalibrateShutter, RefusesACameraAtRest) {
  film(80e-6, 0, 26);
  const test::TypedOutcome outcome = calibrate();
  EXPECT_EQ(outcome.status, ExitStatus::kWorkFailed);
  EXPECT_NE(outcome.line.find("the motion is too slow"), std::string::npos) << outcome.line;
  EXPECT_FALSE(fs::exists(out()));
}

TEST_F(CalibrateShutter, RefusesOnePictureAndNone) {
  film(80e-6, 1, 1);
  EXPECT_NE(calibrate().line.find("one picture shows no motion"), std::string::npos) << calibrate().line;
  fs::remove_all(folder_.path() + "/frames");
  EXPECT_EQ(calibrate().status, ExitStatus::kWrongUsage);
}

TEST_F(CalibrateShutter, SaysAtOnceThatNothingCanBeWrittenThere) {
  film(80e-6, 1, 1);
  const test::TypedOutcome outcome =
      run({"rolling-shutter", folder_.path(), "--out", folder_.path() + "/none/out.toml"});
  EXPECT_EQ(outcome.status, ExitStatus::kWorkFailed);
  EXPECT_NE(outcome.line.find("none/out.toml"), std::string::npos) << outcome.line;
}

}  // namespace
}  // namespace ninedot
