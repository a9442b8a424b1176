#include "calibrate/camera_file.h"

#include <gtest/gtest.h>

#include "base/startup_error.h"
#include "programs/assembly/input_files.h"

namespace ninedot {
namespace {

const std::string kRos =
    "image_width: 640\n"
    "image_height: 480\n"
    "camera_name: wide\n"
    "camera_matrix:\n"
    "  rows: 3\n"
    "  cols: 3\n"
    "  data: [720, 0, 319.5, 0, 721, 239.5, 0, 0, 1]\n"
    "distortion_model: plumb_bob\n"
    "distortion_coefficients:\n"
    "  rows: 1\n"
    "  cols: 5\n"
    "  data: [-0.12, 0.05, 0.0008, -0.0005, 0]\n";

const std::string kOpenCv = R"(%YAML:1.0
---
calibration_time: "Tue Mar  3 11:12:13 2026"
image_width: 1280
image_height: 960
flags: 0
camera_matrix: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 1.4400000000000000e+03, 0., 6.3950000000000000e+02, 0.,
       1.4410000000000000e+03, 4.7950000000000000e+02, 0., 0., 1. ]
distortion_coefficients: !!opencv-matrix
   rows: 8
   cols: 1
   dt: d
   data: [ 1.0e-01, -2.0e-01, 1.0e-03, 2.0e-03, 5.0e-02, 0.3, 0.4, 0.5 ]
avg_reprojection_error: 2.1e-01
)";

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string error_of(const std::string& text) {
  try {
    parse_camera(text, "c.yaml");
  } catch (const StartupError& error) {
    EXPECT_EQ(error.status, ExitStatus::kWrongUsage);
    return error.what();
  }
  return "no error";
}

std::string error_with(const std::string& from, const std::string& to) { return error_of(replaced(kRos, from, to)); }

TEST(CameraFile, ReadsTheFormOfRos) {
  const CameraModel camera = parse_camera(kRos, "c.yaml");
  EXPECT_EQ(camera.width_px, 640);
  EXPECT_EQ(camera.height_px, 480);
  EXPECT_EQ(camera.fx_px, 720);
  EXPECT_EQ(camera.fy_px, 721);
  EXPECT_EQ(camera.cx_px, 319.5);
  EXPECT_EQ(camera.cy_px, 239.5);
  EXPECT_EQ(camera.model, DistortionModel::kPlumbBob);
  EXPECT_EQ(camera.k, (std::array<double, 8>{-0.12, 0.05, 0.0008, -0.0005, 0, 0, 0, 0}));
}

TEST(CameraFile, ReadsTheFormOfOpenCv) {
  const CameraModel camera = parse_camera(kOpenCv, "c.yaml");
  EXPECT_EQ(camera.width_px, 1280);
  EXPECT_EQ(camera.fy_px, 1441);
  EXPECT_EQ(camera.cx_px, 639.5);
  EXPECT_EQ(camera.model, DistortionModel::kRationalPolynomial);
  EXPECT_EQ(camera.k[7], 0.5);
}

TEST(CameraFile, ReadsFisheyeCalibrations) {
  const std::string four =
      replaced(replaced(kRos, "cols: 5", "cols: 4"), "[-0.12, 0.05, 0.0008, -0.0005, 0]", "[0.1, 0.2, 0.3, 0.4]");
  EXPECT_EQ(parse_camera(four, "c.yaml").model, DistortionModel::kPlumbBob);
  EXPECT_EQ(parse_camera(replaced(four, "plumb_bob", "equidistant"), "c.yaml").model, DistortionModel::kEquidistant);
  EXPECT_EQ(parse_camera(replaced(four, "distortion_model: plumb_bob", "fisheye_model: 1"), "c.yaml").model,
            DistortionModel::kEquidistant);
}

TEST(CameraFile, ReadsBackEveryModelItWrote) {
  CameraModel camera;
  camera.fx_px = 701.123456789012345;
  camera.k = {0.1, -1e-7, 1.0 / 3, 4, 0, 0, 0, 0};
  for (const DistortionModel model :
       {DistortionModel::kPlumbBob, DistortionModel::kRationalPolynomial, DistortionModel::kEquidistant}) {
    camera.model = model;
    const CameraModel read = parse_camera(format_camera(camera, "test"), "c.yaml");
    EXPECT_EQ(read.model, model);
    EXPECT_EQ(read.fx_px, camera.fx_px);
    EXPECT_EQ(read.k, camera.k);
    EXPECT_EQ(read.width_px, camera.width_px);
    EXPECT_EQ(read.cy_px, camera.cy_px);
  }
}

TEST(CameraFile, ReadsTheBundledCalibrations) {
  const CameraModel camera =
      read_camera_file(std::string(NINEDOT_SOURCE_DIR) + "/tests/recordings/distorted/camera.yaml");
  EXPECT_EQ(camera.k[0], -0.12);
}

TEST(CameraFile, NamesTheLineOfEveryMistake) {
  EXPECT_EQ(error_of(""), "c.yaml:1: not a calibration: expected 'key: value' lines");
  EXPECT_EQ(error_with("image_width: 640\n", ""), "c.yaml:1: 'image_width' is missing");
  EXPECT_EQ(error_with("image_height: 480", "image_height: 480.5"),
            "c.yaml:2: image_height is 480.5, not a whole number of pixels from 1 to 8192");
  EXPECT_EQ(error_with("image_height: 480", "image_height: 0"),
            "c.yaml:2: image_height is 0, not a whole number of pixels from 1 to 8192");
  EXPECT_EQ(error_with("image_height: 480", "image_width: 480"), "c.yaml:2: 'image_width' is there twice");
  EXPECT_EQ(error_with("[720,", "[.nan,"), "c.yaml:7: camera_matrix, number 1 is '.nan', not a finite number");
  EXPECT_EQ(error_with("[720,", "[inf,"), "c.yaml:7: camera_matrix, number 1 is 'inf', not a finite number");
  EXPECT_EQ(error_with("[720,", "[-720,"), "c.yaml:5: fx is -720 px; a focal length is positive");
  EXPECT_EQ(error_with("721", "5.4"),
            "c.yaml:5: fy is 5.4 px, implausible for a picture 640 px wide; it is in pixels, not mm");
  EXPECT_EQ(error_with("319.5", "700"),
            "c.yaml:5: the principal point (700, 239.5) is outside the picture of 640 x 480 px");
  EXPECT_EQ(error_with("[720, 0,", "[720, 1.5,"), "c.yaml:5: camera_matrix has a skew of 1.5 px; write 0");
  EXPECT_EQ(error_with("0, 0, 1]", "0, 0, 2]"), "c.yaml:5: camera_matrix is not [fx, 0, cx, 0, fy, cy, 0, 0, 1]");
  EXPECT_EQ(error_with(", 0, 0, 1]", ", 0, 1]"), "c.yaml:5: camera_matrix has 8 numbers, but rows x cols is 3 x 3");
  EXPECT_EQ(error_with("0.0008, -0.0005, 0]", "0.0008, -0.0005]"),
            "c.yaml:10: distortion_coefficients has 4 numbers, but rows x cols is 1 x 5");
  EXPECT_EQ(error_with("plumb_bob", "rational_polynomial"),
            "c.yaml:10: rational_polynomial takes 8 coefficients; there are 5");
  EXPECT_EQ(error_with("plumb_bob", "equidistant"), "c.yaml:10: equidistant takes 4 coefficients; there are 5");
  EXPECT_EQ(error_with("plumb_bob", "thin_prism"),
            "c.yaml:8: unknown distortion_model 'thin_prism'; there are plumb_bob, rational_polynomial, equidistant");
  EXPECT_EQ(error_with("[720,", "[720").substr(0, 9), "c.yaml:7:");
  EXPECT_EQ(error_with("  data: [-0.12", "   data: [-0.12").find('\n'), std::string::npos);
}

TEST(CameraFile, RefusesEveryTruncationOfTheBundledFileOrReadsItsNumbersUnchanged) {
  const CameraModel whole = parse_camera(kRos, "c.yaml");
  for (std::size_t length = 0; length < kRos.size(); ++length) {
    try {
      const CameraModel camera = parse_camera(kRos.substr(0, length), "c.yaml");
      EXPECT_EQ(camera.k, whole.k) << length;
    } catch (const StartupError& error) {
      EXPECT_EQ(std::string(error.what()).find("c.yaml:"), 0U) << length;
    }
  }
}

TEST(CameraFile, RefusesAFileThatIsNotThere) {
  try {
    read_camera_file("/nonexistent/camera.yaml");
    FAIL();
  } catch (const StartupError& error) {
    EXPECT_STREQ(error.what(), "/nonexistent/camera.yaml: cannot be opened: No such file or directory");
  }
}

}  // namespace
}  // namespace ninedot
