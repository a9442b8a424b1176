#include "programs/assembly/open_source.h"

#include <gtest/gtest.h>

#include "base/startup_error.h"

namespace ninedot {
namespace {

std::string refusal_of_calibration(const std::string& path) {
  CameraConfig config;
  config.source = "v4l2";
  config.calibration = path;
  try {
    static_cast<void>(read_camera_calibration(config));
  } catch (const StartupError& error) {
    EXPECT_EQ(error.status, ExitStatus::kWrongUsage);
    return error.what();
  }
  return "";
}

TEST(CameraCalibrationFile, IsRefusedByItsPathHoweverLongThatIs) {
  EXPECT_EQ(refusal_of_calibration("/does/not/exist.yaml"),
            "/does/not/exist.yaml: no such calibration; set camera.calibration");
  const std::string too_long = "/" + std::string(300, 'x');
  EXPECT_EQ(refusal_of_calibration(too_long), too_long + ": cannot be opened: File name too long");
}

}  // namespace
}  // namespace ninedot
