// `ninedot calibrate pan-tilt` on a simulated head, in virtual time: the head is taken along its tour as by the command
// itself, and what it told and saw is recorded.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>

#include "base/startup_error.h"
#include "base/units.h"
#include "calibrate/camera_file.h"
#include "calibrate_head/head_sufficiency.h"
#include "config/config_checks.h"
#include "config/head_options.h"
#include "drivers/recording/recording_writer.h"
#include "programs/assembly/localiser_options.h"
#include "programs/assembly/make_localiser.h"
#include "programs/assembly/open_source.h"
#include "programs/assembly/simulation_options.h"
#include "programs/commands/commands.h"
#include "programs/commands/head_file_text.h"
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

struct Switch final : DigitalInput {
  bool is_on = false;
  bool is_active() const noexcept override { return is_on; }
};

/// The loop of `ninedot calibrate pan-tilt` without a recording, on a clock that waits for nothing.
class VirtualTour {
 public:
  VirtualTour(const Config& config, int columns, int rows)
      : camera_(read_camera_calibration(config.camera).camera),
        source_(simulation_options(config, camera_, 7), line_, clock_),
        servos_(line_, clock_, start_angles(config.pan_tilt)),
        head_(camera_, aim_options(config.pan_tilt), servos_, &inhibit, {false, start_angles(config.pan_tilt)}),
        drive_(tour_options(config, camera_, columns, rows), toured_),
        localiser_(make_localiser(camera_, localiser_options(config))) {}

  /// \param writer  null: nothing is recorded
  void step(RecordingWriter* writer = nullptr) {
    Result<FrameLease> lease = source_.next(clock_.now() + HeadOutput::kPeriod);
    if (lease) {
      drive_.take(lease->frame, localiser_->process(lease->frame));
      lease->frame.head = drive_.told();
      lease->frame.chroma = {};
      if (writer != nullptr) {
        EXPECT_TRUE(writer->add(*lease));
      }
    }
    head_.take(Report{}, false, clock_.now());
  }
  const CameraModel& camera() const { return camera_; }
  const HeadTourDrive& drive() const { return drive_; }
  HeadAngles commanded() const { return servos_.state().angles; }

  Switch inhibit;

 private:
  const CameraModel camera_;
  VirtualClock clock_;
  const std::shared_ptr<HeadLine> line_ = std::make_shared<HeadLine>();
  SimulatedCamera source_;
  SimulatedHead servos_;
  HeadOutput head_;
  OutputHead toured_{head_};
  HeadTourDrive drive_;
  const std::unique_ptr<FrameProcessor> localiser_;
};

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
  {
    VirtualTour tour(config_of(kScenario), 5, 4);
    RecordingWriter writer(walk(), format_camera(tour.camera(), "simulated"));
    while (!tour.drive().is_over()) tour.step(&writer);
  }
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

TEST_F(CalibratePanTilt, StandsWhileTheInhibitInputIsActiveAndGoesOnAfterwards) {
  VirtualTour tour(config_of(kScenario), 3, 3);
  while (tour.drive().tour().stops_made() < 3) tour.step();
  while (tour.drive().told() == tour.drive().tour().goal()) tour.step();  // on its way
  tour.inhibit.is_on = true;
  tour.step();
  const HeadAngles stopped = tour.commanded();
  const std::size_t made = tour.drive().tour().stops_made();
  const HeadAngles goal = tour.drive().tour().goal();
  for (int i = 0; i < 500; ++i) tour.step();
  EXPECT_TRUE(tour.drive().is_inhibited());
  EXPECT_EQ(tour.commanded(), stopped);
  EXPECT_EQ(tour.drive().tour().stops_made(), made);
  tour.inhibit.is_on = false;
  for (int i = 0; i < 20; ++i) tour.step();
  EXPECT_EQ(tour.drive().tour().goal(), goal) << "the stop that it was on its way to is not given up";
  for (int i = 0; i < 100'000 && !tour.drive().is_over(); ++i) tour.step();
  EXPECT_TRUE(tour.drive().is_over());
  EXPECT_EQ(tour.drive().tour().stops_made(), tour.drive().tour().stops_planned());
  EXPECT_TRUE(what_stops_lack(find_stops(tour.drive().frames())).empty());
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
  refusal({"--stops", "4294967303x5"}, ExitStatus::kWrongUsage, "write COLUMNSxROWS");
  refusal({"--stops", " 7x 5"}, ExitStatus::kWrongUsage, "write COLUMNSxROWS");
  refusal({walk(), "--stops", "7x5"}, ExitStatus::kWrongUsage, "--stops is for a head that is moved now");
  refusal({"--camera", "camera.yaml"}, ExitStatus::kWrongUsage, "--camera belongs to recordings");

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
  refusal({walk(), walk() + "/../walk"}, ExitStatus::kWrongUsage, "is given twice");
  EXPECT_EQ(run({walk(), "--config", config, "--out", config}).status, ExitStatus::kWrongUsage);
  EXPECT_TRUE(fs::file_size(config) > 0) << "what is read is not written over";
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

/// An axis that truly turns twice as far as it is told, and a little more below.
AxisCalibration doubled() {
  AxisCalibration axis;
  axis.points = {{-0.4, -0.9, 1e-3}, {0, 0, 0}, {0.4, 0.8, 1e-3}};
  axis.sees_play = true;
  return axis;
}

TEST(HeadFileText, TablesKeepTheCornersOfTheOldOneWithinWhatWasTravelled) {
  const std::vector<AxisPoint> old{{-1, 1100}, {-0.2, 1400}, {0.002, 1500}, {1, 1900}};
  const ServoAxis said(old, 900, 2100);
  const std::vector<AxisPoint> points = corrected_table(doubled(), said, {-1, -0.2, 0.002, 1});
  ASSERT_EQ(points.size(), 4U) << "both ends, the corner at -0.2, and one of the two that are nearly at 0";
  EXPECT_NEAR(points[0].angle_rad, -0.9, 1e-9);
  EXPECT_NEAR(points[0].output, 1325, 1e-9);
  EXPECT_NEAR(points[1].angle_rad, -0.45, 1e-9);
  EXPECT_NEAR(points[1].output, 1400, 1e-9);
  EXPECT_NEAR(points[2].output, 1500, 1e-9);
  EXPECT_NEAR(points[3].angle_rad, 0.8, 1e-9);
}

TEST(HeadFileText, TablesOfAReversedAxisStillRiseByAngle) {
  AxisCalibration axis = doubled();
  for (TablePoint& point : axis.points) point.angle_rad = -point.angle_rad;
  const std::vector<AxisPoint> points =
      corrected_table(axis, ServoAxis(std::vector<AxisPoint>{{-1, 1000}, {1, 2000}}, 900, 2100), {});
  ASSERT_EQ(points.size(), 3U);
  EXPECT_LT(points[0].angle_rad, points[2].angle_rad);
  EXPECT_GT(points[0].output, points[2].output);
}

TEST(HeadFileText, HasRoomForTheLongestTable) {
  std::vector<AxisPoint> old;
  std::vector<double> corners;
  for (int i = 0; i < 32; ++i) {
    corners.push_back(-0.35 + 0.022 * i);
    old.push_back({corners.back(), 1000.0 + 20 * i});
  }
  const std::vector<AxisPoint> points = corrected_table(doubled(), ServoAxis(old, 500, 2500), corners);
  EXPECT_GT(points.size(), 30U);
  EXPECT_LE(points.size(), ServoAxis::kMaxPoints);
}

TEST(HeadFileText, IsEmptyWhereTheAxisTurnsBackAndSaysStepsWhereThereAreNoPulses) {
  AxisCalibration back = doubled();
  back.points[2].angle_rad = -0.1;
  EXPECT_TRUE(corrected_table(back, ServoAxis(std::vector<AxisPoint>{{-1, 1000}, {1, 2000}}, 900, 2100), {}).empty());
  HeadCalibration head;
  head.pan = head.tilt = doubled();
  for (TablePoint& point : head.tilt.points) point.told_rad /= 2, point.angle_rad /= 2;
  const std::string visca =
      head_file_text(head, config_of("[pan_tilt]\ndriver = \"visca\"\ndevice = \"/dev/ttyS0\"\n"), "x");
  EXPECT_NE(visca.find("# [deg, steps]"), std::string::npos) << visca;
  EXPECT_EQ(
      config_of(visca + "[pan_tilt]\ndriver = \"visca\"\ndevice = \"/dev/ttyS0\"\n").pan_tilt.pan.calibration.size(),
      3U);
  const std::string none = head_file_text(head, {}, "a folder\nof a strange name");
  EXPECT_EQ(none.find("[pan_tilt.pan]"), std::string::npos);
  EXPECT_EQ(config_of(none).body.camera_mm[0], 0);
  head.pan = back;
  EXPECT_THROW(head_file_text(head, config_of("[pan_tilt]\ndriver = \"visca\"\ndevice = \"/dev/ttyS0\"\n"), "x"),
               StartupError);
}

}  // namespace
}  // namespace ninedot
