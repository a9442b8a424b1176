#include "calibrate/camera_file_text.h"

#include <gtest/gtest.h>

#include <string>

#include "calibrate/camera_file.h"

namespace ninedot {
namespace {

CameraModel camera(DistortionModel model, int coefficients) {
  CameraModel result{640, 480, 612.25, 611.125, 323.1, 236.4, model, {}};
  for (int i = 0; i < coefficients; ++i) result.k[static_cast<std::size_t>(i)] = 0.1 / (i + 3);
  return result;
}

CalibrationNotes notes(int parameters) {
  CalibrationNotes result{"2026-11-22", "", "4 mm: \"C\\S\"\nmount",     60, 0.04, 0.012,
                          0.05,         {}, {"for people", "two\nlines"}};
  result.covariance = Eigen::MatrixXd::Identity(parameters, parameters) * 1e-6;
  result.covariance(0, 1) = result.covariance(1, 0) = -2.5e-9;
  return result;
}

TEST(CameraFileText, ReadsBackAsTheSameCameraToTheLastBit) {
  for (const auto& [model, count] : {std::pair{DistortionModel::kPlumbBob, 5},
                                     {DistortionModel::kRationalPolynomial, 8},
                                     {DistortionModel::kEquidistant, 4}}) {
    const CameraModel truth = camera(model, count);
    const CameraModel read = parse_camera(format_calibrated_camera(truth, "name", notes(4 + count)), "file");
    EXPECT_EQ(read.fx_px, truth.fx_px);
    EXPECT_EQ(read.cy_px, truth.cy_px);
    EXPECT_EQ(read.model, truth.model);
    EXPECT_EQ(read.k, truth.k);
  }
}

TEST(CameraFileText, HasTheKeysThatReadersGoBy) {
  const std::string text = format_calibrated_camera(camera(DistortionModel::kPlumbBob, 5), "name", notes(9));
  for (const char* part : {"# for people\n# two?lines\n", "\ncalibration:", "\n  date: \"2026-11-22\"",
                           "\n  camera_id: \"\"", "\n  lens: \"4 mm: \\\"C\\\\S\\\"?mount\"\n", "\n  views: 60\n",
                           "\n  rms_px: 0.04 ", "\n  direction_sigma_px: 0.012 ", "\n  direction_sigma_max_px: 0.05 ",
                           "\n    rows: 9\n    cols: 9\n    data: [1e-06, -2.5e-09, 0, "})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
}

}  // namespace
}  // namespace ninedot
