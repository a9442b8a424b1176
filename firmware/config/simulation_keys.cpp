#include "config/simulation_keys.h"

#include <fmt/format.h>

#include <array>

namespace ninedot {
namespace {

constexpr double kLongest_s = 86400;     // a day
constexpr double kMaxPosition_mm = 1e7;  // as that of landmarks
constexpr double kMaxArm_mm = 10000;     // as in [body]

#define SLOT(member) [](Config& config) -> ConfigSlot { return &config.simulation.member; }
#define SERVO_SLOT(member) SLOT(servo.member)
#define HEAD_SLOT(member) SLOT(head.member)

const std::array kKeys{
    ConfigKey{"simulation", "duration_s", "s", 0.1, kLongest_s, "",
              "how long it lasts; the service then starts it again, unless `loop` of `[camera]` is false",
              SLOT(duration_s)},
    ConfigKey{"simulation", "camera_delay_ms", "ms", 0, 1000, "",
              "from the middle of an exposure to the frame's arrival", SLOT(camera_delay_ms)},
    ConfigKey{"simulation", "noise_lsb", "", 0, 30, "",
              "1-sigma of a pixel's grey level at 128 of 255; most of it shot noise", SLOT(noise_lsb)},
    ConfigKey{"simulation", "blur_px", "px", 0, 2, "", "1-sigma of the lens's point spread", SLOT(blur_px)},

    ConfigKey{"simulation.robot", "t_s", "s", 0, kLongest_s, "", "when it is there; must be given, and rise",
              SLOT(robot.back().t_s)},
    ConfigKey{"simulation.robot", "x_mm", "mm", -kMaxPosition_mm, kMaxPosition_mm, "",
              "place of the body's origin in the world", SLOT(robot.back().x_mm)},
    ConfigKey{"simulation.robot", "y_mm", "mm", -kMaxPosition_mm, kMaxPosition_mm, "", "likewise",
              SLOT(robot.back().y_mm)},
    ConfigKey{"simulation.robot", "z_mm", "mm", -kMaxPosition_mm, kMaxPosition_mm, "", "likewise",
              SLOT(robot.back().z_mm)},
    ConfigKey{"simulation.robot", "heading_deg", "deg", -36000, 36000, "",
              "of the body's x axis about the world's Z; from 170 to -170 it turns by 340 deg, from 170 to 190 by 20",
              SLOT(robot.back().heading_deg)},

    ConfigKey{"simulation.hidden", "from_s", "s", 0, kLongest_s, "", "must be given", SLOT(hidden.back().from_s)},
    ConfigKey{"simulation.hidden", "to_s", "s", 0, kLongest_s, "", "must be given", SLOT(hidden.back().to_s)},

    ConfigKey{"simulation.servo", "speed_deg_s", "deg/s", 1, 36000, "", "fastest turn; 353 is 0.17 s for 60 deg",
              SERVO_SLOT(speed_deg_s)},
    ConfigKey{"simulation.servo", "acceleration_deg_s2", "deg/s^2", 1, 1e6, "", "fastest change of the turn's speed",
              SERVO_SLOT(acceleration_deg_s2)},
    ConfigKey{"simulation.servo", "dead_band_deg", "deg", 0, 45, "",
              "it is driven only while it is farther than this from where it was told to stand",
              SERVO_SLOT(dead_band_deg)},
    ConfigKey{"simulation.servo", "backlash_deg", "deg", 0, 45, "",
              "play between the servo and the camera, from one end to the other", SERVO_SLOT(backlash_deg)},
    ConfigKey{"simulation.servo", "resolution_deg", "deg", 0, 45, "",
              "commands are rounded to multiples of this; 0 = not", SERVO_SLOT(resolution_deg)},
    ConfigKey{"simulation.servo", "delay_ms", "ms", 0, 1000, "", "from a command until the servo begins to obey it",
              SERVO_SLOT(delay_ms)},
    ConfigKey{"simulation.servo", "pan_start_deg", "deg", -180, 180, "",
              "where the axis stands before its first command, which is `neutral_deg`", SERVO_SLOT(pan_start_deg)},
    ConfigKey{"simulation.servo", "tilt_start_deg", "deg", -180, 180, "", "likewise", SERVO_SLOT(tilt_start_deg)},

    ConfigKey{"simulation.head", "tilt_axis_mm", "mm", -kMaxArm_mm, kMaxArm_mm, "", "as in `[body]`; none = as there",
              HEAD_SLOT(tilt_axis_mm)},
    ConfigKey{"simulation.head", "camera_mm", "mm", -kMaxArm_mm, kMaxArm_mm, "", "likewise", HEAD_SLOT(camera_mm)},
    ConfigKey{"simulation.head", "camera_rpy_deg", "deg", -180, 180, "", "likewise", HEAD_SLOT(camera_rpy_deg)},
    ConfigKey{"simulation.head", "pan_calibration", "", -1e5, 1e5, "",
              "points `[angle_deg, pulse_us]`: where a pulse truly turns the axis; none = where `[pan_tilt.pan]` says",
              HEAD_SLOT(pan_calibration)},
    ConfigKey{"simulation.head", "tilt_calibration", "", -1e5, 1e5, "", "likewise", HEAD_SLOT(tilt_calibration)},
};
#undef HEAD_SLOT
#undef SERVO_SLOT
#undef SLOT

void check_path(const SimulationConfig& simulation, ConfigProblems& problems) {
  for (std::size_t i = 1; i < simulation.robot.size(); ++i) {
    const double before_s = simulation.robot[i - 1].t_s, t_s = simulation.robot[i].t_s;
    if (t_s <= before_s)
      problems.add(problems.line_of(fmt::format("simulation.robot.{}.t_s", i)),
                   fmt::format("'t_s' is {}; write more than {}, the time of the way-point before", t_s, before_s));
  }
  for (std::size_t i = 0; i < simulation.hidden.size(); ++i)
    if (const HiddenConfig& hidden = simulation.hidden[i]; hidden.to_s < hidden.from_s)
      problems.add(problems.line_of(fmt::format("simulation.hidden.{}.to_s", i)),
                   fmt::format("'to_s' is {}; write no less than from_s = {}", hidden.to_s, hidden.from_s));
}

void check_table(const char* key, const std::vector<AxisPoint>& points, ConfigProblems& problems) {
  if (!points.empty() && !ServoAxis::accepts(points))
    problems.add(
        problems.line_of(fmt::format("simulation.head.{}", key)),
        fmt::format("'{}' is of no use; write 2 to {} pairs whose angles rise and whose pulses all rise or all "
                    "fall",
                    key, ServoAxis::kMaxPoints));
}

void check_start(const char* key, double start_deg, const HeadAxisConfig& axis, ConfigProblems& problems) {
  if (start_deg < axis.min_deg || start_deg > axis.max_deg)
    problems.add(problems.line_of(fmt::format("simulation.servo.{}", key)),
                 fmt::format("'{}' is {}; write {} to {}, min_deg to max_deg of the axis in [pan_tilt]", key, start_deg,
                             axis.min_deg, axis.max_deg));
}

}  // namespace

std::span<const ConfigKey> simulation_keys() { return kKeys; }

void check_simulation(const Config& config, ConfigProblems& problems) {
  const SimulationConfig& simulation = config.simulation;
  check_path(simulation, problems);
  check_table("pan_calibration", simulation.head.pan_calibration, problems);
  check_table("tilt_calibration", simulation.head.tilt_calibration, problems);
  if (config.camera.source == "simulated" && simulation.robot.empty())
    problems.add(problems.line_of("camera.source"),
                 "'source' is 'simulated', and there is no robot: write [[simulation.robot]], where it is and when");
  // Without a robot there is no simulation, and nothing that starts anywhere.
  if (simulation.robot.empty()) return;
  check_start("pan_start_deg", simulation.servo.pan_start_deg, config.pan_tilt.pan, problems);
  check_start("tilt_start_deg", simulation.servo.tilt_start_deg, config.pan_tilt.tilt, problems);
}

}  // namespace ninedot
