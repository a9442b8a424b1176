// `ninedot calibrate pan-tilt` on a simulated head, in virtual time: the head is taken along its tour as by the command
// itself, and what it told and saw is recorded.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "base/units.h"
#include "calibrate/camera_file.h"
#include "config/config_checks.h"
#include "config/head_options.h"
#include "drivers/recording/recording_writer.h"
#include "programs/assembly/localiser_options.h"
#include "programs/assembly/make_localiser.h"
#include "programs/assembly/open_source.h"
#include "programs/assembly/simulation_options.h"
#include "programs/commands/commands.h"
#include "programs/commands/head_tour_drive.h"
#include "tests/programs/typed_command.h"
#include "tests/recording/temporary_recording.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

/// A head whose every number is wrong in the configuration: an axis that is reversed and 6 % too far, one that is bent,
/// lengths of some centimetres, and servos with play, dead band and coarse steps.
constexpr const char* kScenario = R"([camera]
source = "simulated"
width_px = 320
height_px = 240
rate_hz = 25
[body]
tilt_axis_mm = [0, 0, 40]
[pan_tilt]
driver = "simulated"
[pan_tilt.pan]
min_deg = -40
max_deg = 40
[pan_tilt.tilt]
min_deg = -30
max_deg = 30
[simulation]
duration_s = 1000
[[simulation.robot]]
t_s = 0
x_mm = 60
y_mm = 1100
z_mm = -40
heading_deg = -90
[simulation.head]
tilt_axis_mm = [14, 0, 40]
camera_mm = [33, -8, 21]
camera_rpy_deg = [1.0, -2.0, 1.5]
pan_calibration = [[-63.6, 2100], [0, 1500], [63.6, 900]]
tilt_calibration = [[-36, 1100], [0, 1500], [44, 1900]]
[simulation.servo]
backlash_deg = 0.5
dead_band_deg = 0.1
resolution_deg = 0.05
delay_ms = 30
)";

Config config_of(const std::string& text) {
  ConfigProblems problems;
  return parse_config(text, "scenario.toml", problems);
}

/// The loop of `ninedot calibrate pan-tilt` without a recording, on a clock that waits for nothing.
void record_tour(const Config& config, const std::string& folder, int columns, int rows) {
  const CameraModel camera = read_camera_calibration(config.camera).camera;
  VirtualClock clock;
  const auto line = std::make_shared<HeadLine>();
  SimulatedCamera source(simulation_options(config, camera, 7), line, clock);
  SimulatedHead servos(line, clock, start_angles(config.pan_tilt));
  HeadOutput head(camera, aim_options(config.pan_tilt), servos, nullptr, {false, start_angles(config.pan_tilt)});
  HeadTourDrive drive(tour_options(config, camera, columns, rows), head);
  const auto localiser = make_localiser(camera, localiser_options(config));
  RecordingWriter writer(folder, format_camera(camera, "simulated"));
  const Report nothing;
  MonoTime now = clock.now();
  while (!drive.is_over()) {
    Result<FrameLease> lease = source.next(now + HeadOutput::kPeriod);
    now = clock.now();
    ASSERT_TRUE(lease || lease.error().code == Errc::kNoFrame);
    if (lease) {
      drive.take(lease->frame, localiser->process(lease->frame));
      lease->frame.head = drive.told();
      lease->frame.chroma = {};
      ASSERT_TRUE(writer.add(*lease));
    }
    head.take(nothing, false, now);
  }
}

class CalibratePanTilt : public testing::Test {
 protected:
  static test::TypedOutcome run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"calibrate", "pan-tilt"});
    return test::type_command(add_calibrate_command, std::move(arguments));
  }
  std::string write(const std::string& name, const std::string& text) const {
    folder_.write(name, text);
    return folder_.path() + "/" + name;
  }
  std::string out() const { return folder_.path() + "/head.toml"; }
  std::string walk() const { return folder_.path() + "/walk"; }
  std::string text_of_out() const {
    std::ifstream file(out());
    return {std::istreambuf_iterator<char>(file), {}};
  }

  TemporaryRecording folder_{0};
};

TEST_F(CalibratePanTilt, FindsAHeadOfWhichEveryNumberWasWrong) {
  const std::string config = write("scenario.toml", kScenario);
  record_tour(config_of(kScenario), walk(), 5, 4);
  const test::TypedOutcome outcome = run({walk(), "--config", config, "--out", out()});
  ASSERT_EQ(outcome.status, ExitStatus::kSuccess) << outcome.line;
  SCOPED_TRACE(text_of_out());
  const Config found = config_of(text_of_out());
  const SimulatedHeadConfig truth = config_of(kScenario).simulation.head;
  EXPECT_NEAR(found.body.tilt_axis_mm[0], 14, 3);
  EXPECT_EQ(found.body.tilt_axis_mm[2], 40);
  for (std::size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(found.body.camera_mm[i], (*truth.camera_mm)[i], 4);
    EXPECT_NEAR(found.body.camera_rpy_deg[i], (*truth.camera_rpy_deg)[i], 0.35);
  }
  // Half the play, and what it stops short of within its dead band.
  EXPECT_NEAR(found.body.pan_sigma_deg, 0.35, 0.08);
  const auto expect_table = [](const std::vector<AxisPoint>& table, const std::vector<AxisPoint>& true_table) {
    ASSERT_GE(table.size(), 2U);
    const ServoAxis axis(table, 0, 3000), true_axis(true_table, 0, 3000);
    for (const double pulse_us : {1350.0, 1420.0, 1500.0, 1580.0, 1650.0})
      EXPECT_NEAR(axis.angle_at(pulse_us) * kDegPerRad, true_axis.angle_at(pulse_us) * kDegPerRad, 0.3) << pulse_us;
  };
  expect_table(found.pan_tilt.pan.calibration, truth.pan_calibration);
  expect_table(found.pan_tilt.tilt.calibration, truth.tilt_calibration);
  EXPECT_NE(outcome.said.find("landmark, 0 left out"), std::string::npos) << outcome.said;
}

TEST_F(CalibratePanTilt, RefusesWithOneLineAndLeavesNothingBehind) {
  const std::string config = write("scenario.toml", kScenario);
  const auto refusal = [&](std::vector<std::string> arguments, ExitStatus status, const std::string& what) {
    arguments.insert(arguments.end(), {"--config", config, "--out", out()});
    test::expect_refusal(run(arguments), status, what);
    EXPECT_FALSE(fs::exists(out()));
  };
  refusal({folder_.path() + "/none"}, ExitStatus::kWrongUsage, "none");
  refusal({"--stops", "7"}, ExitStatus::kWrongUsage, "--stops 7: write COLUMNSxROWS");
  refusal({"--stops", "1x200"}, ExitStatus::kWrongUsage, "3 to 25 of each");

  // A head that is only ever told one place, as without frames.csv.
  Config still = config_of(kScenario);
  const CameraModel camera = read_camera_calibration(still.camera).camera;
  VirtualClock clock;
  SimulatedCamera source(simulation_options(still, camera, 1), std::make_shared<HeadLine>(), clock);
  {
    RecordingWriter writer(walk(), format_camera(camera, "simulated"));
    for (int i = 0; i < 20; ++i) {
      Result<FrameLease> lease = source.next(clock.now() + std::chrono::seconds(1));
      ASSERT_TRUE(lease);
      lease->frame.chroma = {};
      ASSERT_TRUE(writer.add(*lease));
    }
  }
  refusal({walk()}, ExitStatus::kWorkFailed, "no angles of a head that moves");
  const auto pretend = [&](double pan_deg, double tilt_deg) {
    std::string csv = "frame,timestamp_ns,pan_deg,tilt_deg\n";
    for (int i = 0; i < 20; ++i)
      csv += fmt::format("{},{},{},{}\n", i, 200'000'000LL * i, i < 10 ? 0 : pan_deg, i < 10 ? 0 : tilt_deg);
    folder_.write("walk/frames.csv", csv);
  };
  pretend(3, 0);
  refusal({walk()}, ExitStatus::kWorkFailed, "the pan axis moved by 3 degrees: move it by 20 at least; the tilt axis");
  test::expect_refusal(run({walk(), "--config", config, "--out", folder_.path() + "/none/head.toml"}),
                       ExitStatus::kWorkFailed, "none/head.toml");
}

TEST_F(CalibratePanTilt, MovesNothingWithoutAHeadOrACamera) {
  const auto refusal = [&](const std::string& text, ExitStatus status, const std::string& what) {
    test::expect_refusal(run({"--config", write("scenario.toml", text), "--out", out()}), status, what);
    EXPECT_FALSE(fs::exists(out()));
  };
  refusal("[camera]\nsource = \"v4l2\"\ndevice = \"/dev/none\"", ExitStatus::kWrongUsage, "there is no head to move");
  refusal("[camera]\nsource = \"recording\"\ndevice = \"walk\"\n[pan_tilt]\ndriver = \"simulated\"",
          ExitStatus::kWrongUsage, "camera.source is \"recording\"");
  write("camera.yaml", format_camera(read_camera_calibration(config_of(kScenario).camera).camera, "simulated"));
  refusal(
      "[camera]\nsource = \"v4l2\"\ndevice = \"/dev/none\"\nwidth_px = 320\nheight_px = 240\ncalibration = "
      "\"camera.yaml\"\n[pan_tilt]\ndriver = \"simulated\"",
      ExitStatus::kWorkFailed, "/dev/none");
}

}  // namespace
}  // namespace ninedot
