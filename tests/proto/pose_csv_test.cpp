#include "proto/pose_csv.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

namespace ninedot {
namespace {

WireReport known_report() {
  WireReport report;
  report.valid = report.found = report.has_pose = true;
  report.reason = Reason::kNone;
  report.frame_number = 17;
  report.exposed_at = mono_from_ns(485'714'286);
  report.landmark_id = 3;
  report.camera_in_landmark = {{123.456789, 1500, -1e-9}, {0.5, -0.5, 0.5, -0.5}};
  report.swing_psi_deg = 30;
  report.tilt_phi_deg = 45;
  report.pan_theta_deg = -90;
  report.distance_mm = 1505.072;
  report.sigma_landmark_mm = {1, 2, 3};
  report.sigma_rotation_deg = 0.003 * 180 / std::numbers::pi;
  report.ambiguity = 0.25;
  report.rms_px = 0.0625;
  report.dots_used = 8;
  report.occlusion_level = 1;
  report.ellipse_solver = true;
  report.process_us = 812.34;
  return report;
}

TEST(PoseCsv, WritesTheBytesOfOneKnownReport) {
  EXPECT_EQ(format_pose_csv_row(known_report()),
            "17,485714286,3,123.456789,1500.000000,0.000000,0.500000000,-0.500000000,0.500000000,-0.500000000,"
            "30.000000,45.000000,-90.000000,1505.072000,1.000000,2.000000,3.000000,0.171887,0.250000,0.062500,8,1,"
            "ellipse,812.3,1,0,0.000000,,,,,,,,\n");
}

TEST(PoseCsv, SaysOfAFoundLandmarkThatIsNotValidWhyAndWhatElseItMayBe) {
  WireReport report = known_report();
  report.valid = false;
  report.reason = Reason::kAmbiguous;
  report.rival_odds = 0.25;
  report.rival_in_landmark = {{1, 2, 3}, {1, 0, 0, 0}};
  const std::string row = format_pose_csv_row(report);
  EXPECT_TRUE(
      row.ends_with(",812.3,0,10,0.250000,1.000000,2.000000,3.000000,1.000000000,0.000000000,0.000000000,"
                    "0.000000000,\n"))
      << row;
  EXPECT_EQ(std::ranges::count(row, ','), std::ranges::count(pose_csv_header(), ','));
}

TEST(PoseCsv, EndsWithWhatOfTheSigmasIsTheCalibrations) {
  WireReport report = known_report();
  report.sigma_calibration_landmark_mm = 0.75;
  EXPECT_TRUE(format_pose_csv_row(report).ends_with(",0.000000,,,,,,,,0.750000\n"));
  EXPECT_TRUE(pose_csv_header().ends_with(",sigma_calibration_mm\n"));
}

TEST(PoseCsv, HasAsManyFieldsInARowAsInItsHeader) {
  for (const PoseCsvColumns columns : {PoseCsvColumns::kAll, PoseCsvColumns::kWithoutTime}) {
    const std::string row = format_pose_csv_row(known_report(), columns);
    EXPECT_EQ(std::ranges::count(row, ','), std::ranges::count(pose_csv_header(columns), ','));
  }
}

TEST(PoseCsv, WritesTheSameBytesForTwoRunsWhenTimeIsLeftOut) {
  WireReport other_run = known_report();
  other_run.process_us = 7;
  other_run.latency_ms = 1;
  EXPECT_EQ(format_pose_csv_row(known_report(), PoseCsvColumns::kWithoutTime),
            format_pose_csv_row(other_run, PoseCsvColumns::kWithoutTime));
}

TEST(PoseCsv, ShowsANumberThatIsNoneAsSuch) {
  WireReport report = known_report();
  report.sigma_landmark_mm[0] = kUnknown;
  EXPECT_NE(format_pose_csv_row(report).find("nan"), std::string::npos);
}

TEST(PoseCsv, WritesTheTumTrajectoryFormat) {
  EXPECT_EQ(format_tum_row(known_report()),
            "0.485714286 0.123456789 1.500000000 0.000000000 -0.500000000 0.500000000 -0.500000000 0.500000000\n");
}

TEST(PoseCsvDeathTest, RefusesAReportWithoutAPose) {
  EXPECT_DEATH(format_pose_csv_row(WireReport{}), "report.has_pose");
}

}  // namespace
}  // namespace ninedot
