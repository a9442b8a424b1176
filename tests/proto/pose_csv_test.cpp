#include "proto/pose_csv.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numbers>

namespace ninedot {
namespace {

Report known_report() {
  Report report;
  report.valid = report.found = true;
  report.frame_number = 17;
  report.exposed_at = mono_from_ns(485'714'286);
  report.landmark_id = 3;
  report.camera_in_landmark = {{0.123456789, 1.5, -1e-12}, {0.5, -0.5, 0.5, -0.5}};
  report.swing_psi_rad = std::numbers::pi / 6;
  report.tilt_phi_rad = std::numbers::pi / 4;
  report.pan_theta_rad = -std::numbers::pi / 2;
  report.distance_m = 1.505072;
  report.covariance[0] = 1e-6, report.covariance[7] = 4e-6, report.covariance[14] = 9e-6;
  report.covariance[21] = 1e-6, report.covariance[28] = 4e-6, report.covariance[35] = 4e-6;
  report.ambiguity = 0.25;
  report.rms_px = 0.0625;
  report.dots_used = 8;
  report.occlusion_level = 1;
  report.solver = Solver::kEllipse;
  report.process_time = std::chrono::nanoseconds(812'340);
  return report;
}

TEST(PoseCsv, WritesTheBytesOfOneKnownReport) {
  EXPECT_EQ(format_pose_csv_row(known_report()),
            "17,485714286,3,123.456789,1500.000000,0.000000,0.500000000,-0.500000000,0.500000000,-0.500000000,"
            "30.000000,45.000000,-90.000000,1505.072000,1.000000,2.000000,3.000000,0.171887,0.250000,0.062500,8,1,"
            "ellipse,812.3\n");
}

TEST(PoseCsv, HasAsManyFieldsInARowAsInItsHeader) {
  for (const PoseCsvColumns columns : {PoseCsvColumns::kAll, PoseCsvColumns::kWithoutTime}) {
    const std::string row = format_pose_csv_row(known_report(), columns);
    EXPECT_EQ(std::ranges::count(row, ','), std::ranges::count(pose_csv_header(columns), ','));
  }
}

TEST(PoseCsv, WritesTheSameBytesForTwoRunsWhenTimeIsLeftOut) {
  Report other_run = known_report();
  other_run.process_time = std::chrono::nanoseconds(7);
  other_run.published_at = mono_from_ns(1);
  EXPECT_EQ(format_pose_csv_row(known_report(), PoseCsvColumns::kWithoutTime),
            format_pose_csv_row(other_run, PoseCsvColumns::kWithoutTime));
}

TEST(PoseCsv, ShowsANumberThatIsNoneAsSuch) {
  Report report = known_report();
  report.covariance[0] = -1;
  EXPECT_NE(format_pose_csv_row(report).find("nan"), std::string::npos);
}

TEST(PoseCsv, WritesTheTumTrajectoryFormat) {
  EXPECT_EQ(format_tum_row(known_report()),
            "0.485714286 0.123456789 1.500000000 0.000000000 -0.500000000 0.500000000 -0.500000000 0.500000000\n");
}

TEST(PoseCsvDeathTest, RefusesAReportWithoutAPose) { EXPECT_DEATH(format_pose_csv_row(Report{}), "report.valid"); }

}  // namespace
}  // namespace ninedot
