#pragma once
/// The configuration file: TOML, strict. An unknown, repeated or out-of-range key is an error with its line.
/// config_reference.cpp holds the table of all keys, from which reading, checking and docs/configuration.md follow.
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "aim/servo_axis.h"

namespace ninedot {

/// [camera]
struct CameraConfig {
  std::string source = "recording";  ///< `source`: libcamera | v4l2 | recording | simulated
  std::string device;                ///< `device`: v4l2 path, libcamera id, or the recording's folder or .y4m file
  int width_px = 640;                ///< `width_px`: 16..8192
  int height_px = 480;               ///< `height_px`: 16..8192
  double rate_hz = 35.0;  ///< `rate_hz`: 0.1..100000; frames per second asked of the camera, or of the recording
  std::string pixel_format = "auto";     ///< `pixel_format`: auto, GREY, Y10, YUYV, NV12, ...
  double exposure_us = 0;                ///< `exposure_us`: 0 = automatic .. 1e6
  double gain = 0.0;                     ///< `gain`: 0 = automatic .. 1000
  double black_level = 0;                ///< `black_level`: 0..4000, of a Bayer format's numbers
  double red_gain = 1, blue_gain = 1;    ///< `red_gain`, `blue_gain`: 0.1..16 times green, of a Bayer format
  std::string calibration;               ///< `calibration`: camera.yaml; empty = the recording's own
  bool lower_rate_in_the_dark = false;   ///< `lower_rate_in_the_dark`: automatic exposure may lower the frame rate
  std::string power_line = "unchanged";  ///< `power_line`: unchanged | off | 50Hz | 60Hz | automatic
  std::string focus = "unchanged";       ///< `focus`: unchanged | fixed | automatic
  double focus_position = -1;            ///< `focus_position`: -1 = not said, 0..1e6 [driver's steps], libcamera [1/m]
  double readout_us = 0;                 ///< `readout_us`: 0..1e6, end of the exposure to the end of the frame
  /// `row_time_us`: 0..1000; from one row's exposure to the next's, 0 = global shutter; none: nobody has said
  std::optional<double> row_time_us;
  int stall_frames = 10;        ///< `stall_frames`: 3..1000 frame periods without a frame: the camera is lost
  bool wait_for_device = true;  ///< `wait_for_device`: of older files; `ninedotd` waits whatever it says
  bool loop = true;             ///< `loop`: a recording starts again at its end
  bool every_frame = false;  ///< `every_frame`: a recording's frames one after another, as fast as they are processed
};

/// [landmark]: the geometry that all landmarks share
struct LandmarkConfig {
  double ring_radius_mm = 80.0;      ///< `ring_radius_mm`: > 0, at most 10000
  double dot_diameter_mm = 25.4;     ///< `dot_diameter_mm`: > 0, dots must not touch
  double centre_diameter_mm = 50.8;  ///< `centre_diameter_mm`: > 0
  double expected_roll_deg = 0.0;  ///< `expected_roll_deg`: -180..180; roll of the camera at which P1 is the lowest dot
  double roll_sigma_deg = 5.0;     ///< `roll_sigma_deg`: 0.1..90; 1-sigma of the roll about that
};

/// [[landmarks]]: the map; none = one black-and-white landmark, id 0, at the world's origin
struct MapLandmarkConfig {
  int id = 0;                                        ///< `id`: 0..65535, unique
  std::string code;                                  ///< `code`: eight of K R G B, P1..P8; empty = black and white
  std::optional<std::array<double, 3>> position_mm;  ///< `position_mm = [x, y, z]`; none = the place is unknown
  double heading_deg = 0.0;                          ///< `heading_deg`: about the world's Z
  /// `orientation_wxyz = [w, x, y, z]` [1]: the quaternion world from landmark, near unit length; none = upright
  std::optional<std::array<double, 4>> orientation_wxyz;
  std::array<double, 3> sigma_position_mm{};   ///< `sigma_position_mm`: 1-sigma along the world's axes; 0 = exact
  std::array<double, 3> sigma_rotation_deg{};  ///< `sigma_rotation_deg`: 1-sigma about the world's axes; 0 = exact
  bool from_pictures = false;  ///< `from_pictures`: the place is `ninedot map`'s, which finds it anew; false = measured
};

/// [pose]
struct PoseConfig {
  std::string solver = "full";  ///< `solver`: full | ellipse
  bool tracking = true;         ///< `tracking`: look where the landmark was before searching the whole picture
  double max_ambiguity = 0.01;  ///< `max_ambiguity`: 0..1; odds of another reading above which a pose is not valid
  std::string main_landmark = "nearest";  ///< `main_landmark`: nearest | surest; of several in view the reported one
  double max_sigma_percent = 3.0;  ///< `max_sigma_percent`: 0.01..10 % of the distance; 1-sigma above it: not valid
};

/// [pose.ellipse]: what the founding paper calibrates; all zero = nothing was calibrated
struct EllipseConfig {
  double kmm_mm_per_px = 0;  ///< `kmm_mm_per_px`: 0 = not calibrated; millimetres per pixel of the sensor
  double p1 = 0;             ///< `p1`: -1..1 [mm/px]; F(D') = p1 + p2 D'^p3, equation (9), D' in mm
  double p2 = 0;             ///< `p2`: -1e6..1e6 [mm/px], of a D' of 1 mm
  double p3 = 0;             ///< `p3`: -10..10 [1]
  double cu = 0, cv = 0;     ///< `cu`, `cv`: -1..1 [1/px^2]; off-centre correction, equations (32) and (33)
};

/// [track]: the filter on the camera's pose in the world, see docs/method.md
struct TrackConfig {
  double acceleration_sigma_m_s2 = 0.3;           ///< `acceleration_sigma_m_s2`: 0.001..100; 1-sigma, each axis
  double angular_acceleration_sigma_deg_s2 = 60;  ///< `angular_acceleration_sigma_deg_s2`: 0.1..100000; likewise
  double common_share = 0.2;  ///< `common_share`: 0..0.9; of a frame's variance, what it shares with the next one
};

/// [body]: where the camera sits on the robot; all zero = it is the body's origin and looks along x
struct BodyConfig {
  std::array<double, 3> pan_axis_mm{};             ///< `pan_axis_mm = [x, y, z]`: a point of the pan axis, in the body
  std::array<double, 3> mount_rpy_deg{};           ///< `mount_rpy_deg = [roll, pitch, yaw]`: of the head's foot
  std::array<double, 3> tilt_axis_mm{};            ///< `tilt_axis_mm = [x, y, z]`: of the tilt axis from the pan axis
  std::array<double, 3> camera_mm{};               ///< `camera_mm = [x, y, z]`: the optical centre from the tilt axis
  std::array<double, 3> camera_rpy_deg{};          ///< `camera_rpy_deg = [roll, pitch, yaw]`: the camera on its head
  double pan_sigma_deg = 0, tilt_sigma_deg = 0;    ///< `pan_sigma_deg`, `tilt_sigma_deg`: 0..30; of the angles told
  double mount_sigma_mm = 0, mount_sigma_deg = 0;  ///< `mount_sigma_mm`, `mount_sigma_deg`: each axis, 1-sigma
};

/// [pan_tilt.pan], [pan_tilt.tilt]
struct HeadAxisConfig {
  double min_deg = -45, max_deg = 45;         ///< `min_deg`, `max_deg`: -180..180; the axis is never sent beyond
  double neutral_deg = 0;                     ///< `neutral_deg`: where it waits for the first landmark
  std::optional<double> start_deg, park_deg;  ///< `start_deg`, `park_deg`: none = neutral_deg
  double slew_deg_per_s = 60;                 ///< `slew_deg_per_s`: 0.1..3600
  double acceleration_deg_per_s2 = 1000;      ///< `acceleration_deg_per_s2`: 1..1e5
  std::string direction = "normal";           ///< `direction`: normal | reversed
  double centre_us = 1500, us_per_deg = 10;   ///< `centre_us`, `us_per_deg`: pulse at 0 deg, and its change
  double min_us = 1000, max_us = 2000;        ///< `min_us`, `max_us`: 200..5000; no pulse is ever beyond
  std::vector<AxisPoint> calibration;         ///< `calibration`: [[angle_deg, pulse_us], ...]
  std::string chip;                           ///< `chip`: sysfs-pwm: the PWM chip's device
  int channel = 0;                            ///< `channel`: sysfs-pwm: 0..63; pca9685: 0..15
  int id = 1;                                 ///< `id`: dynamixel, feetech: 0..252; of tilt 2
  std::string line;                           ///< `line`: gpio: NAME or LABEL:OFFSET
};

/// [pan_tilt]
struct PanTiltConfig {
  std::string driver = "none";    ///< `driver`: none | sysfs-pwm | pca9685 | gpio | visca | dynamixel | feetech-sts |
                                  ///< feetech-scs | simulated
  bool follow = true;             ///< `follow`: the head follows the landmark from the start on
  double gain = 0.5;              ///< `gain`: 0.01..1; part of the deviation that one frame takes away, at 35 Hz
  double dead_band_deg = 0.2;     ///< `dead_band_deg`: 0..10; a smaller deviation is no reason to move
  double head_delay_ms = 20;      ///< `head_delay_ms`: 0..500; from a command until the head stands there
  double coast_ms = 1000;         ///< `coast_ms`: 0..60000; so long a landmark out of sight is followed on
  bool search = true;             ///< `search`: sweep for a landmark that was lost
  bool search_at_start = false;   ///< `search_at_start`: also before one was seen
  double search_deg_per_s = 45;   ///< `search_deg_per_s`: 0.1..3600
  double park_after_s = 0;        ///< `park_after_s`: 0 = never .. 1e6; without a landmark in sight
  bool park_at_shutdown = false;  ///< `park_at_shutdown`
  std::string landmark = "hand-over";    ///< `landmark`: hand-over | nearest | reported | id
  int landmark_id = 0;                   ///< `landmark_id`: 0..65535; of landmark = "id"
  double hand_over_margin_percent = 20;  ///< `hand_over_margin_percent`: 0..90
  double period_ms = 20;                 ///< `period_ms`: 5..40; of servo pulses
  int pulse_priority = 60;      ///< `pulse_priority`: gpio: 0 (off)..99, SCHED_FIFO of the thread that makes pulses
  std::string device;           ///< `device`: visca, dynamixel, feetech: serial port; pca9685: I2C bus
  int baud = 0;                 ///< `baud`: dynamixel, feetech: of kServoBaudRates [baud]; 0 = as the maker sets it
  int address = -1;             ///< `address`: visca: 1..7; pca9685: 0x40..0x77; -1 = the first of them
  double oscillator_hz = 25e6;  ///< `oscillator_hz`: pca9685: 1e6..5e7
  std::string output_enable;    ///< `output_enable`: pca9685: NAME or LABEL:OFFSET of its OE pin; empty = wired
  std::string when_stopped = "release";  ///< `when_stopped`: release | hold; pca9685, dynamixel, feetech
  int zoom = -1;                         ///< `zoom`: 0..1023 [steps]; visca sets it at the start; -1 = left as it is
  HeadAxisConfig pan, tilt;
  PanTiltConfig() { tilt.channel = 1, tilt.id = 2; }
};

/// [gpio]: single lines; empty = none
struct GpioConfig {
  std::string servo_power, status_led, inhibit;  ///< `servo_power`, `status_led`, `inhibit`: NAME or LABEL:OFFSET
  bool servo_power_active_low = false, status_led_active_low = false, inhibit_active_low = false;
  std::string inhibit_bias = "unchanged";  ///< `inhibit_bias`: unchanged | pull-up | pull-down
};

/// [modbus]
struct ModbusConfig {
  double position_scale_16bit_mm = 0.5;  ///< `position_scale_16bit_mm`: 0.01..100; one step of the 16-bit x, y, z
  std::string float_word_order = "high-first";  ///< `float_word_order`: high-first | low-first
  bool allow_writes = false;                    ///< `allow_writes`: commands by function codes 06 and 16
  std::uint32_t hold_ms = 500;                  ///< `hold_ms`: 10..10000; HOLD releases itself after this time
};

/// [modbus.tcp]
struct ModbusTcpConfig {
  bool enabled = false;              ///< true when the table is present
  std::string listen = "127.0.0.1";  ///< `listen`: IPv4 or IPv6 address
  std::uint16_t port = 1502;         ///< `port`: 1..65535
  int max_clients = 16;              ///< `max_clients`: 1..64
  double idle_timeout_s = 60;        ///< `idle_timeout_s`: 1..86400; a connection without a request is closed
  std::vector<std::string> allow;    ///< `allow`: addresses that may connect; empty = all
};

/// [modbus.rtu]
struct ModbusRtuConfig {
  bool enabled = false;               ///< true when the table is present
  std::string device = "/dev/ttyS1";  ///< `device`
  int baud = 115200;                  ///< `baud`: 1200..921600, a standard rate
  char parity = 'E';                  ///< `parity`: N | E | O
  int unit = 1;                       ///< `unit`: 1..247
};

/// [outputs]
struct OutputsConfig {
  std::string pose = "camera_in_world";  ///< `pose`: camera_in_world | camera_in_landmark | body_in_world
  std::string euler = "zyx";             ///< `euler`: zyx | fanuc | kuka
};

/// [tap]
struct TapConfig {
  bool enabled = false;                       ///< `enabled`: the newest frame for others, in shared memory
  std::string path = "/run/ninedot-tap/tap";  ///< `path`: of the file, in a folder in memory
};

/// [web]: of `ninedot-web`, which reads the tap
struct WebConfig {
  std::string listen = "127.0.0.1";  ///< `listen`: IPv4 or IPv6 address
  std::uint16_t port = 8090;         ///< `port`: 1..65535
  std::vector<std::string> names;    ///< `names`: by which browsers call this machine, beside its addresses
  std::string token_file;         ///< `token_file`: whoever knows what it holds may look; empty = all that can connect
  std::string certificate, key;   ///< `certificate`, `key`: PEM files for TLS; empty = no TLS
  double pictures_per_s = 10;     ///< `pictures_per_s`: 0.5..12
  double ar_pictures_per_s = 40;  ///< `ar_pictures_per_s`: 0.5..60, while somebody looks at the view AR
  int quality = 75;               ///< `quality`: 20..95, of the JPEG pictures
  std::string recordings;   ///< `recordings`: folder that the page's recordings are kept in; empty = none are made
  int recordings_mb = 500;  ///< `recordings_mb`: 10..1000000, of all of them together
  int recording_s = 60;     ///< `recording_s`: 1..3600, the longest
  double loss_seconds = 0;  ///< `loss_seconds`: 0 (off)..30, kept from before each loss of the landmark
  int losses = 10;          ///< `losses`: 1..100, recordings of losses that are kept
};

/// [service]
struct ServiceConfig {
  int realtime_priority = 50;  ///< `realtime_priority`: 0 (off)..99, SCHED_FIFO of the frame loop
  bool lock_memory = true;     ///< `lock_memory`: mlockall
};

/// [[simulation.robot]]: a way-point of the body
struct WayPointConfig {
  double t_s = 0;                       ///< `t_s`: 0..86400, later than the one before
  double x_mm = 0, y_mm = 0, z_mm = 0;  ///< `x_mm`, `y_mm`, `z_mm`: of the body's origin, in the world
  double heading_deg = 0;               ///< `heading_deg`: -36000..36000; of the body's x axis about the world's Z
};

/// [[simulation.hidden]]: everything is covered
struct HiddenConfig {
  double from_s = 0, to_s = 0;  ///< `from_s`, `to_s`: 0..86400, in this order
};

/// [simulation.servo]: the true dynamics of both axes of the simulated head
struct SimulatedServoConfig {
  double speed_deg_s = 353;           ///< `speed_deg_s`: 1..36000; fastest turn: 0.17 s for 60 deg
  double acceleration_deg_s2 = 6000;  ///< `acceleration_deg_s2`: 1..1e6 [deg/s^2]; fastest change of that
  double dead_band_deg = 0;           ///< `dead_band_deg`: 0..45; to each side of where it was told to stand
  double backlash_deg = 0;            ///< `backlash_deg`: 0..45; play between the servo and the camera, end to end
  double resolution_deg = 0;          ///< `resolution_deg`: 0..45; step of the commands; 0 = none
  double delay_ms = 0;                ///< `delay_ms`: 0..1000; from the command until it takes effect
  double pan_start_deg = 0;           ///< `pan_start_deg`: -180..180; where it stands before its first command
  double tilt_start_deg = 0;          ///< `tilt_start_deg`: -180..180
};

/// [simulation.head]: how the simulated head is truly made, where that is not what [body] and [pan_tilt] say of it
struct SimulatedHeadConfig {
  /// `tilt_axis_mm`, `camera_mm`, `camera_rpy_deg`: as in [body]; none = what stands there
  std::optional<std::array<double, 3>> tilt_axis_mm, camera_mm, camera_rpy_deg;
  /// `pan_calibration`, `tilt_calibration`: [[angle_deg, pulse_us], ...]; empty = what the axis has in [pan_tilt]
  std::vector<AxisPoint> pan_calibration, tilt_calibration;
};

/// [simulation]: for `ninedot simulate`, and for `ninedotd` with camera.source = "simulated"
struct SimulationConfig {
  double duration_s = 10;             ///< `duration_s`: 0.1..86400
  double camera_delay_ms = 20;        ///< `camera_delay_ms`: 0..1000; mid-exposure to the frame's arrival
  double noise_lsb = 2;               ///< `noise_lsb`: 0..30; 1-sigma of a pixel's grey level at 128 of 255
  double blur_px = 0.6;               ///< `blur_px`: 0..2; 1-sigma of the lens's point spread
  std::vector<WayPointConfig> robot;  ///< none: there is no simulation
  std::vector<HiddenConfig> hidden;
  SimulatedServoConfig servo;
  SimulatedHeadConfig head;
};

struct Config {
  std::string map;  ///< `map`: file that holds the [[landmarks]] in this one's place; empty = they stand here
  CameraConfig camera;
  LandmarkConfig landmark;
  std::vector<MapLandmarkConfig> landmarks;
  PoseConfig pose;
  EllipseConfig ellipse;
  TrackConfig track;
  BodyConfig body;
  PanTiltConfig pan_tilt;
  GpioConfig gpio;
  ModbusConfig modbus;
  ModbusTcpConfig modbus_tcp;
  ModbusRtuConfig modbus_rtu;
  OutputsConfig outputs;
  TapConfig tap;
  WebConfig web;
  ServiceConfig service;
  SimulationConfig simulation;
};

}  // namespace ninedot
