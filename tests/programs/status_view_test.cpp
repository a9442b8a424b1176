#include "programs/display/status_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "tests/proto/known_report.h"

namespace ninedot {
namespace {

const MonoTime kNow = mono_from_ns(5'000'000'000'000);

RegisterBlock registers_of(const WireReport& report, const MetricValues& metrics = test::known_metrics(),
                           const RegisterCodecOptions& options = {}) {
  return encode_registers(report, metrics, test::known_server_state(kNow), options);
}

TEST(StatusTable, SaysPoseUncertaintyHeadAndHealthInTheRegistersUnits) {
  const RegisterBlock registers = registers_of(test::known_report(kNow));
  EXPECT_EQ(status_table(make_reader(registers)),
            "pose       valid, tracking, held by this client (landmark 7, quality 913/1000, age 12.3 ms)\n"
            "                     x           y           z\n"
            "position      1234.568   -2500.000    3276.700 mm\n"
            "  1-sigma         0.12        0.34        2.10 mm\n"
            "  of these        1.50 mm are the calibration's, all axes together\n"
            "rotation        17.189     -22.918      68.755 deg (rotation vector, body to world)\n"
            "  1-sigma        0.029       0.057       0.115 deg\n"
            "angles         123.457     -45.250    -180.000 deg (KUKA A, B, C)\n"
            "  1-sigma        0.123       0.046           ? deg\n"
            "landmark   9 of 9 dots, residual 0.046 px, ambiguity 0.12, full solver\n"
            "or else    x -321.5 y 4000.2 z 17.0 mm, by another reading: odds 0.120\n"
            "in view    3 landmarks of the map, 1 NOT WHERE THE MAP SAYS (number 12)\n"
            "map        2 landmarks CONTRADICT each other (numbers 21 and 22): measure them\n"
            "head       COAST, pan 12.34 deg, tilt -5.67 deg, at its LIMIT, INHIBITED\n"
            "frames     35.0 Hz, 100000 processed, 65537 dropped, 3 failed, 2 camera restarts\n"
            "latency    median 8.7 ms, p99 9.5, p99.9 12.0, max 33.3 (capture to report)\n"
            "service    up 1:01:01, real-time, memory locked, board 47.3 degC\n"
            "Modbus     2 connected, 5 bus errors, 4 exceptions answered, 65542 requests,\n"
            "           11 connections since the start, 12 REFUSED, 13 expired, 14 frames of other units,\n"
            "           serial line LOST 15 times, serial line open\n"
            "servos     head LOST 16 times, 11.9 V, 48 degC, load 17 %, pulses off by 7 us (p99), max 21\n"
            "search     17 runs cut, 18 blobs cut, 19 hypotheses cut, 20 neighbours cut,\n"
            "           21 frames searched in part\n"
            "shutter    33.28 us from row to row, 1-sigma 0.62, camera.row_time_us is WRONG\n"
            "device     ninedot 1.20.300, serial number of the board 10000000a1b2c3d\n");
}

TEST(StatusTable, SaysWhosePoseItIsAndNamesTheAnglesThatAreAskedFor) {
  const auto table_of = [](const PoseOutput& output) {
    WireReport report = test::known_report(kNow);
    report.output = output;
    const RegisterBlock registers = registers_of(report);
    return status_table(make_reader(registers));
  };
  using enum PoseContent;
  using enum EulerConvention;
  EXPECT_EQ(table_of({}).find("angles"), std::string::npos) << table_of({});
  EXPECT_NE(table_of({}).find("camera to world"), std::string::npos);
  EXPECT_NE(table_of({kCameraInWorld, kFanuc}).find("(FANUC W, P, R)"), std::string::npos);
  EXPECT_NE(table_of({kCameraInLandmark, kZyx}).find("camera to landmark"), std::string::npos);
  EXPECT_NE(table_of({kBodyInWorld, kZyx}).find("deg (yaw, pitch, roll)"), std::string::npos);
}

TEST(StatusTable, ShowsNothingThatIsNotKnownAsANumber) {
  const RegisterBlock registers = registers_of(WireReport{}, MetricValues{});
  const RegisterReader reader = make_reader(registers);
  const std::string table = status_table(reader), json = status_json(reader), line = status_line(reader);
  for (const char* const never : {"655.35", "65.535", "6553.5 ms ("}) {
    EXPECT_EQ(table.find(never), std::string::npos) << table;
    EXPECT_EQ(line.find(never), std::string::npos) << line;
  }
  for (const char* const unknown : {"\"landmark_id\":null", "\"sigma_x\":null", "\"sigma_rotation_z\":null",
                                    "\"residual\":null", "\"x_32\":null", "\"x_float\":null"})
    EXPECT_NE(json.find(unknown), std::string::npos) << unknown << " in " << json;
}

TEST(StatusTable, LeavesTheHeadOutWhereThereIsNoneAndFitsIntoAHundredColumns) {
  WireReport report = test::known_report(kNow);
  report.has_head = false;
  report.sigma_calibration_mm = kUnknown;
  report.rival_odds = 0;
  report.output = {};
  report.landmarks_seen = 1, report.landmarks_rejected = 0, report.landmarks_disputed = 0;
  const RegisterBlock registers = registers_of(report, MetricValues{});
  const std::string table = status_table(make_reader(registers));
  EXPECT_EQ(table.find("head"), std::string::npos);
  EXPECT_EQ(std::ranges::count(table, '\n'), 12) << "what has never happened takes no room\n" << table;
  std::istringstream lines(table);
  for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 100U) << line;
}

TEST(StatusTable, SaysWhyThereIsNoPoseAndWhatIsNotKnown) {
  WireReport report = test::known_report(kNow);
  report.valid = report.found = false;
  report.reason = Reason::kCameraLost;
  report.exposed_at = kNow - std::chrono::seconds(60);
  MetricValues metrics = test::known_metrics();
  metrics[MetricId::kTemperature] = std::nan("");
  metrics[MetricId::kServoSupply] = metrics[MetricId::kServoLoad] = std::nan("");
  const RegisterBlock registers = registers_of(report, metrics);
  const std::string table = status_table(make_reader(registers));
  EXPECT_NE(table.find("NOT VALID: the camera"), std::string::npos) << table;
  EXPECT_NE(table.find("age > 6.5 s"), std::string::npos) << table;
  EXPECT_NE(table.find("board ? degC"), std::string::npos) << table;
  EXPECT_NE(table.find("head LOST 16 times, 48 degC, pulses"), std::string::npos)
      << "what servos don't tell: " << table;
}

TEST(StatusLine, CountsOneClientAsOne) {
  MetricValues metrics = test::known_metrics();
  for (const MetricId id : {MetricId::kConnectedClients, MetricId::kBusErrors, MetricId::kRequests}) metrics[id] = 1;
  const RegisterBlock registers = registers_of(test::known_report(kNow), metrics);
  EXPECT_TRUE(status_line(make_reader(registers)).ends_with(", 1 client")) << status_line(make_reader(registers));
  const std::string table = status_table(make_reader(registers));
  EXPECT_NE(table.find("1 connected, 1 bus error, 4 exceptions answered, 1 request,"), std::string::npos) << table;
}

TEST(StatusLine, IsOneLineWithoutEscapeCodes) {
  const RegisterBlock registers = registers_of(test::known_report(kNow));
  const std::string line = status_line(make_reader(registers));
  EXPECT_EQ(line.find_first_of("\n\x1b"), std::string::npos);
  EXPECT_NE(line.find("x 1234.6 y -2500.0 z 3276.7 mm (1-sigma 0.12 0.34 2.10), 9 dots"), std::string::npos) << line;
}

TEST(StatusJson, IsTheSameForBothWordOrders) {
  const RegisterBlock high = registers_of(test::known_report(kNow));
  const RegisterBlock low =
      registers_of(test::known_report(kNow), test::known_metrics(), {.float_word_order = WordOrder::kLowFirst});
  EXPECT_NE(high, low);
  EXPECT_EQ(status_json(make_reader(high)), status_json(make_reader(low)));
  EXPECT_NE(status_json(make_reader(high)).find("\"x_float\":1234.567"), std::string::npos);
  EXPECT_NE(status_json(make_reader(high)).find("\"servo_limit\""), std::string::npos);
  EXPECT_NE(status_json(make_reader(high)).find("\"head_state_text\":\"COAST\""), std::string::npos);
  EXPECT_NE(status_json(make_reader(high)).find("\"head_state\":4"), std::string::npos);
}

}  // namespace
}  // namespace ninedot
