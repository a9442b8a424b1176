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
      replaced(replaced(kRos, "cols: 5", "cols: 4"), "[-0.12, 0.05, 0.0008, -0.0005, 0]", "[0.1, 0.02, 0.003, 0.0004]");
  EXPECT_EQ(parse_camera(four, "c.yaml").model, DistortionModel::kPlumbBob);
  EXPECT_EQ(parse_camera(replaced(four, "plumb_bob", "equidistant"), "c.yaml").model, DistortionModel::kEquidistant);
  EXPECT_EQ(parse_camera(replaced(four, "distortion_model: plumb_bob", "fisheye_model: 1"), "c.yaml").model,
            DistortionModel::kEquidistant);
}

/// What `calibration` may say, in full: a covariance of 9 x 9 with the variances 1, 1/2, 1/3 ... and fx with fy.
std::string full_record() {
  std::string data;
  for (int row = 0; row < 9; ++row)
    for (int column = 0; column < 9; ++column) {
      const bool is_focal = row < 2 && column < 2;
      data += (data.empty() ? "" : ", ") + std::to_string(row == column ? 1.0 / (row + 1) : is_focal ? 0.5 : 0.0);
    }
  return "calibration:\n"
         "  date: \"2026-11-22\"\n"
         "  camera_id: \"usb-046d:0825-1A2B\"\n"
         "  lens: 6 mm f/2.0\n"
         "  views: 60\n"
         "  rms_px: 0.04\n"
         "  direction_sigma_px: 0.012\n"
         "  direction_sigma_max_px: 0.05\n"
         "  something_later: [1, 2]\n"
         "  covariance:\n"
         "    rows: 9\n"
         "    cols: 9\n"
         "    data: [" +
         data + "]\n";
}

std::string error_of_record(const std::string& from, const std::string& to) {
  return error_of(kRos + replaced(full_record(), from, to));
}

TEST(CameraFile, ReadsWhatACalibrationSaysOfItself) {
  const CalibrationRecord record = parse_calibration(kRos + full_record(), "c.yaml").record;
  EXPECT_EQ(record.date, "2026-11-22");
  EXPECT_EQ(record.camera_id, "usb-046d:0825-1A2B");
  EXPECT_EQ(record.lens, "6 mm f/2.0");
  EXPECT_EQ(record.views, 60);
  EXPECT_EQ(record.rms_px, 0.04);
  EXPECT_EQ(record.direction_sigma_px, 0.012);
  EXPECT_EQ(record.direction_sigma_max_px, 0.05);
  ASSERT_TRUE(record.covariance);
  EXPECT_EQ((*record.covariance)(0, 0), 1);
  EXPECT_EQ((*record.covariance)(1, 0), 0.5);
  EXPECT_EQ((*record.covariance)(8, 8), 0.111111);
  EXPECT_TRUE(record.covariance->bottomRows<3>().isZero(0)) << "k4 to k6 are not plumb_bob's";
}

TEST(CameraFile, OfBeforeSaysNothingOfItself) {
  for (const std::string& text : {kRos, kOpenCv, kRos + "calibration: {}\n"}) {
    const CalibrationRecord record = parse_calibration(text, "c.yaml").record;
    EXPECT_TRUE(record.date.empty() && record.camera_id.empty() && record.lens.empty());
    EXPECT_FALSE(record.views || record.rms_px || record.direction_sigma_px || record.covariance);
  }
}

TEST(CameraFile, NamesTheLineOfEveryMistakeInWhatItSaysOfItself) {
  EXPECT_EQ(error_of(kRos + "calibration: good\n"),
            "c.yaml:13: calibration is no mapping: write its keys below it, or remove it");
  EXPECT_EQ(error_of_record("2026-11-22", "22.11.2026"),
            "c.yaml:14: date is '22.11.2026', not a day such as \"2026-11-22\"");
  EXPECT_EQ(error_of_record("2026-11-22", "2026-02-30"),
            "c.yaml:14: date is '2026-02-30', not a day such as \"2026-11-22\"");
  EXPECT_EQ(error_of_record("6 mm f/2.0", "\"6 mm\\nf/2.0\""), "c.yaml:16: lens is not one line of text");
  EXPECT_EQ(error_of_record("6 mm f/2.0", "[1]"), "c.yaml:16: lens is not a text");
  EXPECT_EQ(error_of_record("60", "60.5"), "c.yaml:17: views is 60.5, not a whole number up to 1000000");
  EXPECT_EQ(error_of_record("0.04", "-0.04"), "c.yaml:18: rms_px is -0.04; it can't be below 0");
  EXPECT_EQ(error_of_record("0.012", ".inf"), "c.yaml:19: direction_sigma_px is '.inf', not a finite number");
  EXPECT_EQ(error_of_record("  views", "  lens"), "c.yaml:17: 'lens' is there twice");
  EXPECT_EQ(error_of_record("data: [1.000000,", "data: ["),
            "c.yaml:23: covariance has 80 numbers, but rows x cols is 9 x 9");
  EXPECT_EQ(error_of(kRos + "calibration:\n  covariance: [1, 0, 0, 1]\n"),
            "c.yaml:14: covariance has 4 numbers; of fx, fy, cx, cy and 5 coefficients there are 9 x 9");
  std::string zeros = "0";
  for (int i = 1; i < 81; ++i) zeros += ", 0";
  EXPECT_EQ(error_of(kRos + "calibration:\n  covariance: [" + zeros + "]\n"),
            "c.yaml:14: covariance is 0, and nothing is known so well: remove it, or calibrate");
  EXPECT_EQ(error_of_record("data: [1.000000", "data: [-1"),
            "c.yaml:23: covariance, row 1, column 1 is -1; a variance is from 0 to 409600");
  EXPECT_EQ(error_of_record("data: [1.000000", "data: [1e300"),
            "c.yaml:23: covariance, row 1, column 1 is 1e+300; a variance is from 0 to 409600");
  EXPECT_EQ(error_of_record("[1.000000, 0.500000", "[1.000000, 0.400000"), "c.yaml:23: covariance is not symmetric");
  EXPECT_EQ(error_of_record("[1.000000", "[0.4"), "c.yaml:23: covariance is none: an eigenvalue is negative");
  EXPECT_EQ(error_of_record("[1.000000", "[0"), "c.yaml:23: covariance, row 1, column 2 is 0.5 where a variance is 0");
}

TEST(CameraFile, ReadsBackEveryModelItWrote) {
  CameraModel camera;
  camera.fx_px = 701.123456789012345;
  camera.k = {0.1, -1e-7, 1.0 / 3000, 0.004, 0, 0, 0, 0};
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
  EXPECT_EQ(error_with("[-0.12", "[-5"),
            "c.yaml:10: with these coefficients pixels half way to the corners have no direction: no lens bends so");
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
