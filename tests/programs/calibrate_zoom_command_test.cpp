// `ninedot calibrate zoom` as it is typed, on pictures that are rendered through a made-up zoom lens.
#include <gtest/gtest.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "calibrate_camera/lens_uncertainty.h"
#include "drivers/picture/picture_file.h"
#include "programs/assembly/input_files.h"
#include "programs/commands/commands.h"
#include "tests/calibrate_camera/lens_scene.h"
#include "tests/programs/typed_command.h"
#include "tests/support/zoom_lens.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

/// A landmark from many sides, as large in the picture whatever the focal length.
std::vector<test::Picture> pictures_at(int zoom, std::size_t count) {
  const CameraModel lens = test::zoom_lens(zoom);
  test::Holding holding;
  holding.min_distance_m *= lens.fx_px / 600, holding.max_distance_m *= lens.fx_px / 600;
  std::vector<test::Picture> pictures;
  for (std::uint64_t i = 0; i < count; ++i)
    pictures.push_back(test::held_picture(
        lens, test::held_pose(lens, holding, 40 + static_cast<std::uint64_t>(zoom), i), test::nine_dot_sheet(), i));
  return pictures;
}

class CalibrateZoomCommandLine : public testing::Test {
 protected:
  CalibrateZoomCommandLine()
      : folder_(fs::temp_directory_path() / ("ninedot_calibrate_zoom_" + std::to_string(::getpid()))) {
    fs::create_directories(folder_ / "out");
  }
  ~CalibrateZoomCommandLine() override { fs::remove_all(folder_); }

  void record(const std::string& name, const std::vector<test::Picture>& frames) {
    fs::create_directories(folder_ / name / "frames");
    for (std::size_t i = 0; i < frames.size(); ++i) {
      char file[32];
      std::snprintf(file, sizeof file, "%06zu.png", i);
      ASSERT_TRUE(write_png_grey((folder_ / name / "frames" / file).string(), frames[i].view()));
    }
  }
  void record_grey(const std::string& name, int width_px = 640, int height_px = 480) {
    record(name, {test::Picture{width_px, height_px,
                                std::vector<std::uint8_t>(static_cast<std::size_t>(width_px * height_px), 128)}});
  }

  /// `ninedot calibrate zoom --at ZOOM:NAME .. WORDS --out out/zoom.yaml`
  test::TypedOutcome type(const std::vector<std::pair<std::string, std::string>>& at,
                          std::vector<std::string> words = {}) {
    words.insert(words.begin(), {"calibrate", "zoom"});
    for (const auto& [zoom, name] : at) words.insert(words.end(), {"--at", zoom + ":" + path(name)});
    words.insert(words.end(), {"--out", path("out/zoom.yaml")});
    return test::type_command(add_calibrate_command, std::move(words));
  }
  void fails(ExitStatus status, const std::vector<std::pair<std::string, std::string>>& at, const std::string& what) {
    test::expect_refusal(type(at), status, what);
    EXPECT_TRUE(fs::is_empty(folder_ / "out")) << "something was left behind";
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  const fs::path folder_;
};

TEST_F(CalibrateZoomCommandLine, FindsTheLensAtEachOfThreePositions) {
  for (const int zoom : {0, 300, 600}) record(std::to_string(zoom), pictures_at(zoom, 18));
  const auto outcome = type({{"600", "600"}, {"0", "0"}, {"300", "300"}}, {"--model", "plumb_bob"});
  ASSERT_EQ(outcome.status, ExitStatus::kSuccess) << outcome.line;
  EXPECT_NE(outcome.said.find("3 positions: the lens is known at them alone"), std::string::npos) << outcome.said;
  const CameraCalibration read = read_calibration_file(path("out/zoom.yaml"));
  ASSERT_TRUE(read.zoom);
  for (const int zoom : {0, 300, 600}) {
    const auto lens = read.zoom->at(zoom);
    ASSERT_TRUE(lens);
    const CameraModel truth = test::zoom_lens(zoom);
    EXPECT_LT(direction_differences(truth, lens->camera).median_px(), 0.08) << zoom;
    EXPECT_LT(std::abs(lens->camera.fx_px - truth.fx_px), 4 * std::sqrt(lens->covariance(0, 0))) << zoom;
  }
  EXPECT_NEAR(read.camera.fx_px, read.zoom->at(0)->camera.fx_px, 1e-9) << "what other programs read is the widest";
  std::ifstream picture(path("out/zoom.svg"));
  const std::string svg{std::istreambuf_iterator<char>(picture), {}};
  EXPECT_NE(svg.find("Focal length over zoom"), std::string::npos);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_ / "out"), {}), 2);

  // One recording under two positions.
  fs::remove_all(folder_ / "out");
  fs::create_directories(folder_ / "out");
  test::expect_refusal(type({{"0", "0"}, {"300", "0"}}, {"--model", "plumb_bob"}), ExitStatus::kWorkFailed,
                       " px at both 0 and 300; are the positions right?");
  EXPECT_TRUE(fs::is_empty(folder_ / "out"));
}

TEST_F(CalibrateZoomCommandLine, RefusesWhatItCanNotStartFrom) {
  record_grey("a");
  record_grey("b");
  record_grey("small", 320, 240);
  const auto wrong = ExitStatus::kWrongUsage;
  fails(wrong, {{"0", "a"}}, "one position makes no zoom");
  fails(wrong, {{"0", "a"}, {"0", "b"}}, "position 0 is there twice");
  fails(wrong, {{"0", "a"}, {"300", "small"}}, "small: its pictures are 320x240, those of");
  fails(wrong, {{"0", "a"}, {"300", "nowhere"}}, "nowhere");
  for (const char* const zoom : {"", "x", "-1", "1.5", "65536", "99999999999"})
    fails(wrong, {{"0", "a"}, {zoom, "b"}}, "give ZOOM:RECORDING");
  test::expect_refusal(
      test::type_command(add_calibrate_command, {"calibrate", "zoom", "--at", "0:", "--out", path("out/zoom.yaml")}),
      wrong, "--at 0:: give ZOOM:RECORDING");
  std::ofstream(folder_ / "b" / "frames.csv") << "frame,timestamp_ns,zoom\n0,0,312\n";
  fails(wrong, {{"0", "a"}, {"300", "b"}}, "b: frame 0 was taken at zoom 312, not 300");
}

TEST_F(CalibrateZoomCommandLine, NamesTheRecordingThatDoesNotSuffice) {
  record_grey("a");
  record_grey("b");
  fails(ExitStatus::kWorkFailed, {{"0", "a"}, {"300", "b"}},
        "zoom 0, " + path("a") + ": no landmark in any of 1 pictures");
}

}  // namespace
}  // namespace ninedot
