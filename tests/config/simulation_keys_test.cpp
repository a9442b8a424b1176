#include "config/simulation_keys.h"

#include <gtest/gtest.h>

#include <cmath>

#include "config_text.h"

namespace ninedot {
namespace {

using test::error_of;
using test::parse;

const std::string kRobot = "[[simulation.robot]]\nt_s = 0\n";  // lines 1 and 2

TEST(SimulationKeys, AreReadInListsAndTables) {
  const Config config = parse(R"(
[simulation]
duration_s = 6
camera_delay_ms = 20.5
[[simulation.robot]]
t_s = 0.0
x_mm = -2000.0
heading_deg = -90.0
[[simulation.robot]]
t_s = 4
x_mm = 2000
[[simulation.hidden]]
from_s = 2
to_s = 2.5
[simulation.servo]
speed_deg_s = 300
pan_start_deg = 20
)");
  const SimulationConfig& simulation = config.simulation;
  EXPECT_EQ(simulation.duration_s, 6);
  EXPECT_EQ(simulation.camera_delay_ms, 20.5);
  ASSERT_EQ(simulation.robot.size(), 2U);
  EXPECT_EQ(simulation.robot[0].x_mm, -2000);
  EXPECT_EQ(simulation.robot[0].heading_deg, -90);
  EXPECT_EQ(simulation.robot[1].t_s, 4);
  ASSERT_EQ(simulation.hidden.size(), 1U);
  EXPECT_EQ(simulation.hidden[0].to_s, 2.5);
  EXPECT_EQ(simulation.servo.speed_deg_s, 300);
  EXPECT_EQ(simulation.servo.pan_start_deg, 20);
}

TEST(SimulationKeys, SayHowTheHeadTrulyIs) {
  const Config config = parse(R"(
[simulation.head]
camera_mm = [1, 2, 3]
pan_calibration = [[-90, 2100], [90, 900]]
)");
  const SimulatedHeadConfig& head = config.simulation.head;
  EXPECT_FALSE(head.tilt_axis_mm.has_value());
  ASSERT_TRUE(head.camera_mm.has_value());
  EXPECT_EQ((*head.camera_mm)[2], 3);
  ASSERT_EQ(head.pan_calibration.size(), 2U);
  EXPECT_NEAR(head.pan_calibration[0].angle_rad, -M_PI / 2, 1e-12);
  EXPECT_EQ(head.pan_calibration[1].output, 900);
  EXPECT_TRUE(head.tilt_calibration.empty());
  EXPECT_EQ(error_of("[simulation.head]\ntilt_calibration = [[0, 1500], [10, 1500]]").substr(0, 46),
            "t.toml:2: 'tilt_calibration' is of no use; wri");
}

TEST(SimulationKeys, NameTheLineOfWhatIsWrong) {
  EXPECT_EQ(error_of(kRobot + "[[simulation.robot]]\nt_s = 0.0"),
            "t.toml:4: 't_s' is 0; write more than 0, the time of the way-point before");
  EXPECT_EQ(error_of("[[simulation.robot]]\nx_mm = 1"), "t.toml:1: a way-point needs a 't_s'");
  EXPECT_EQ(error_of(kRobot + "x_m = 1"), "t.toml:3: unknown key 'x_m' in [simulation.robot]; did you mean 'x_mm'?");
  EXPECT_EQ(error_of(kRobot + "t_s = 1").substr(0, 9), "t.toml:3:") << "repeated";
  EXPECT_EQ(error_of("[[simulation.hidden]]\nfrom_s = 2"), "t.toml:1: a hidden interval needs a 'to_s'");
  EXPECT_EQ(error_of("[[simulation.hidden]]\nfrom_s = 2\nto_s = 1.5"),
            "t.toml:3: 'to_s' is 1.5; write no less than from_s = 2");
  EXPECT_EQ(error_of("[simulation]\nduration = 2"),
            "t.toml:2: unknown key 'duration' in [simulation]; did you mean 'duration_s'?");
  EXPECT_EQ(error_of("[simulation.robot]\nt_s = 2"),
            "t.toml:1: 'simulation.robot' is a list of tables; write [[simulation.robot]]");
  EXPECT_EQ(error_of("[simulation.servo]\nspeed_deg_s = 0"), "t.toml:2: 'speed_deg_s' is 0; write 1 to 36000 deg/s");
}

TEST(SimulationKeys, RefuseAHeadThatStartsBeyondItsRange) {
  EXPECT_EQ(error_of(kRobot + "[simulation.servo]\npan_start_deg = 50"),
            "t.toml:4: 'pan_start_deg' is 50; write -45 to 45, min_deg to max_deg of the axis in [pan_tilt]");
  EXPECT_EQ(error_of(kRobot + "[simulation.servo]\npan_start_deg = 50\n[pan_tilt.pan]\nmax_deg = 50"), "no error");
  EXPECT_EQ(error_of(kRobot + "[simulation.servo]\ntilt_start_deg = -46").substr(0, 29),
            "t.toml:4: 'tilt_start_deg' is");
}

TEST(SimulationKeys, RefuseASimulatedCameraWithoutARobot) {
  EXPECT_EQ(error_of("[camera]\nsource = \"simulated\""),
            "t.toml:2: 'source' is 'simulated', and there is no robot: write [[simulation.robot]], where it is and "
            "when");
  EXPECT_EQ(error_of(kRobot + "[camera]\nsource = \"simulated\""), "no error");
}

}  // namespace
}  // namespace ninedot
