#include "calibrate/zoom_file.h"

#include <gtest/gtest.h>

#include "base/startup_error.h"
#include "calibrate/camera_file.h"
#include "tests/support/zoom_lens.h"

namespace ninedot {
namespace {

ZoomTable table_of(const std::vector<int>& zooms) {
  std::vector<ZoomLens> lenses;
  for (const int zoom : zooms) {
    ZoomLens& lens = lenses.emplace_back(ZoomLens{zoom, test::zoom_lens(zoom)});
    lens.covariance.topLeftCorner<9, 9>().diagonal() << 0.01, 0.01, 0.04, 0.04, 1e-6, 1e-6, 1e-9, 1e-9, 1e-6;
    lens.covariance(0, 1) = lens.covariance(1, 0) = 0.005;
  }
  return ZoomTable(lenses);
}

std::string text_of(const ZoomTable& table) {
  return format_camera(table.widest().camera, "zoom") + format_zoom(table);
}

std::string error_with(const std::string& from, const std::string& to) {
  std::string text = text_of(table_of({0, 300, 600}));
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  try {
    parse_calibration(text.replace(at, from.size(), to), "z.yaml");
  } catch (const StartupError& error) {
    EXPECT_EQ(error.status, ExitStatus::kWrongUsage);
    return error.what();
  }
  return "no error";
}

TEST(ZoomFile, ReadsBackWhatItWrites) {
  const ZoomTable table = table_of({0, 200, 450, 600, 800, 1023});
  const CameraCalibration read = parse_calibration(text_of(table), "z.yaml");
  EXPECT_EQ(read.camera.fx_px, table.widest().camera.fx_px);
  ASSERT_TRUE(read.zoom);
  ASSERT_EQ(read.zoom->lenses().size(), table.lenses().size());
  for (std::size_t i = 0; i < table.lenses().size(); ++i) {
    const ZoomLens &was = table.lenses()[i], &is = read.zoom->lenses()[i];
    EXPECT_EQ(is.zoom, was.zoom);
    EXPECT_EQ(is.camera.fx_px, was.camera.fx_px);
    EXPECT_EQ(is.camera.fy_px, was.camera.fy_px);
    EXPECT_EQ(is.camera.cx_px, was.camera.cx_px);
    EXPECT_EQ(is.camera.cy_px, was.camera.cy_px);
    EXPECT_EQ(is.camera.k, was.camera.k);
    EXPECT_EQ(is.camera.width_px, was.camera.width_px);
    EXPECT_LT((is.covariance - was.covariance).cwiseAbs().maxCoeff(), 1e-9);
  }
}

TEST(ZoomFile, IsThatOfALockedLensWithoutIt) {
  EXPECT_FALSE(parse_calibration(format_camera(CameraModel{}, "locked"), "c.yaml").zoom);
}

TEST(ZoomFile, NamesTheLineOfEveryMistake) {
  EXPECT_EQ(error_with("zoom:  #", "zoom: 3\nrest:  #"),
            "z.yaml:21: zoom is no mapping: write `positions:` below it, or remove it");
  EXPECT_EQ(error_with("  positions:", "  position:"), "z.yaml:22: 'positions' is missing");
  EXPECT_EQ(error_with("position: 300", "position: -1"),
            "z.yaml:37: position is -1, not a whole number from 0 to 65535");
  EXPECT_EQ(error_with("position: 300", "position: 0.5"),
            "z.yaml:37: position is 0.5, not a whole number from 0 to 65535");
  EXPECT_EQ(error_with("position: 300", "positive: 300"), "z.yaml:37: 'position' is missing");
  EXPECT_EQ(error_with("position: 600", "position: 300"), "z.yaml:23: position 300 is there twice");
  EXPECT_EQ(error_with("position: 600", "position: 200"),
            "z.yaml:51: position 200 comes after 300: write them by rising position");
  EXPECT_EQ(error_with("position: 300\n      parameters: [", "position: 300\n      parameters: [7, "),
            "z.yaml:38: parameters has 10 numbers; fx, fy, cx, cy and the coefficients of the file's model are 9");
  EXPECT_EQ(error_with("position: 300\n      parameters: [", "position: 300\n      parameters: [-"),
            "z.yaml:38: fx is -837.4387078020252 px; a focal length is positive");
  EXPECT_NE(error_with("position: 300\n      parameters: [", "position: 300\n      parameters: [1")
                .find("does not rise all along"),
            std::string::npos);
  EXPECT_EQ(error_with("data: [0.01, 0.005", "data: [-0.01, 0.005"),
            "z.yaml:26: covariance, row 1, column 1 is -0.01; a variance is from 0 to 409600");
  EXPECT_NE(error_with("      covariance:", "      variance:").find("'covariance' is missing"), std::string::npos);
}

}  // namespace
}  // namespace ninedot
