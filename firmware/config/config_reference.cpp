#include "config/config_reference.h"

#include <fmt/format.h>

#include <array>

#include "config/head_keys.h"
#include "config/simulation_keys.h"

namespace ninedot {
namespace {

// The smallest length of a landmark: a tenth of a millimetre is beyond any printer and any camera.
constexpr double kMinLength_mm = 0.1;
constexpr double kMaxLength_mm = 10000;  // 10 m: more is metres taken for millimetres, or a typing error
constexpr double kMaxPosition_mm = 1e7;  // 10 km, a large site; the 32-bit registers end at 2.1 km
constexpr double kMaxSigma_mm = 1e4;     // whoever knows a place no better does not know it

// A macro keeps the table one line per key: a captureless lambda cannot be written shorter.
#define SLOT(member) [](Config& config) -> ConfigSlot { return &config.member; }

constexpr std::string_view kPixelFormats =
    "auto|GREY|NV12|NV21|YU12|YUYV|UYVY|Y10|Y12|Y16|Y10P|Y12P|RGGB10P|BGGR10P|GRBG10P|GBRG10P|RGGB10|BGGR10|GRBG10|"
    "GBRG10|RGGB12P|BGGR12P|GRBG12P|GBRG12P|RGGB12|BGGR12|GRBG12|GBRG12|RGGB|BGGR|GRBG|GBRG|MJPG";

#define LANDMARK_SLOT(member) [](Config& config) -> ConfigSlot { return &config.landmarks.back().member; }

const std::array kKeysUpToTheHead{
    ConfigKey{
        "", "map", "", 0, 0, "",
        "file that holds the `[[landmarks]]`, and nothing else, in this one's place, as `ninedot map` writes it; a "
        "relative path starts at the folder of the configuration file; SIGHUP reads it again; empty = they stand here",
        SLOT(map)},

    ConfigKey{"camera", "source", "", 0, 0, "libcamera|v4l2|recording|simulated",
              "where frames come from; `simulated`: the scenario in `[simulation]`, see docs/simulation.md",
              SLOT(camera.source)},
    ConfigKey{
        "camera", "device", "", 0, 0, "",
        "V4L2 path, or `sensor:NAME` of a sensor behind a media graph (docs/cameras.md), libcamera id, or the "
        "recording's folder or .y4m file; a recording's relative path starts at the folder of the configuration file",
        SLOT(camera.device)},
    ConfigKey{"camera", "width_px", "px", 16, 8192, "", "width of the pictures", SLOT(camera.width_px)},
    ConfigKey{"camera", "height_px", "px", 16, 8192, "", "height of the pictures", SLOT(camera.height_px)},
    ConfigKey{"camera", "rate_hz", "Hz", 0.1, 100000, "", "frames per second asked of the camera, or of the recording",
              SLOT(camera.rate_hz)},
    ConfigKey{"camera", "pixel_format", "", 0, 0, kPixelFormats, "format asked of the camera",
              SLOT(camera.pixel_format)},
    ConfigKey{"camera", "exposure_us", "us", 0, 1e6, "",
              "exposure time; 0 = automatic, or as it is where there is no automatic", SLOT(camera.exposure_us)},
    ConfigKey{"camera", "gain", "", 0, 1000, "",
              "sensor gain, with libcamera a factor, with V4L2 in the driver's units; 0 = automatic, or as it is",
              SLOT(camera.gain)},
    ConfigKey{"camera", "black_level", "", 0, 4000, "",
              "formats from RGGB10P to GBRG, which are a sensor's own numbers: the one that it gives without light, of "
              "its data sheet or of a picture with the lens covered",
              SLOT(camera.black_level)},
    ConfigKey{"camera", "red_gain", "", 0.1, 16, "",
              "the same formats: times red, so that paper is white, see docs/cameras.md", SLOT(camera.red_gain)},
    ConfigKey{"camera", "blue_gain", "", 0.1, 16, "", "likewise times blue", SLOT(camera.blue_gain)},
    ConfigKey{"camera", "lower_rate_in_the_dark", "", 0, 0, "", "automatic exposure may lower the frame rate",
              SLOT(camera.lower_rate_in_the_dark)},
    ConfigKey{"camera", "power_line", "", 0, 0, "unchanged|off|50Hz|60Hz|automatic",
              "V4L2: keeps the exposure clear of the flicker of lamps", SLOT(camera.power_line)},
    ConfigKey{
        "camera", "focus", "", 0, 0, "unchanged|fixed|automatic",
        "`fixed`: autofocus is off, at every opening of the camera, and the lens stands at `focus_position`; with "
        "a calibration an autofocus that is on is refused",
        SLOT(camera.focus)},
    ConfigKey{
        "camera", "focus_position", "", -1, 1e6, "",
        "with `fixed`: where the lens stands, as it did when the camera was calibrated; with V4L2 in the driver's "
        "steps, with libcamera 1 / distance in 1/m; -1 = the lens can't be moved",
        SLOT(camera.focus_position)},
    ConfigKey{"camera", "readout_us", "us", 0, 1e6, "",
              "from the end of the exposure to the end of the frame, for cameras that stamp the end: global shutter "
              "the whole read-out, rolling shutter half of it",
              SLOT(camera.readout_us)},
    ConfigKey{
        "camera", "row_time_us", "us", 0, 1000, "",
        "rolling shutter: from one row's exposure to the next row's; 0 = global shutter, all rows at once; none = "
        "nobody knows: with a map of several landmarks the pictures of a moving camera show it, and until then "
        "its poses are as uncertain as that makes them; one landmark alone counts as seen by a global one. Where "
        "pictures contradict what is said here the log tells it, and poses go by the pictures",
        SLOT(camera.row_time_us)},
    ConfigKey{"camera", "stall_frames", "", 3, 1000, "",
              "so many frame periods without a frame: the camera is lost, and is opened again",
              SLOT(camera.stall_frames)},
    ConfigKey{"camera", "wait_for_device", "", 0, 0, "",
              "of older files, without effect: `ninedotd` starts without its camera and goes on looking for it",
              SLOT(camera.wait_for_device)},
    ConfigKey{
        "camera", "calibration", "", 0, 0, "",
        "camera.yaml of this camera and lens; a relative path starts at the folder of the configuration file; empty = "
        "the recording's own",
        SLOT(camera.calibration)},
    ConfigKey{"camera", "loop", "", 0, 0, "", "a recording starts again at its end", SLOT(camera.loop)},
    ConfigKey{
        "camera", "every_frame", "", 0, 0, "",
        "a recording as a load: whatever `rate_hz` says, each frame comes as soon as the one before is processed, "
        "and none is dropped; it takes a whole processor, and `ninedot status` shows how many frames a second this "
        "board can process",
        SLOT(camera.every_frame)},

    ConfigKey{"landmark", "ring_radius_mm", "mm", kMinLength_mm, kMaxLength_mm, "",
              "radius of the circle through the middles of P1..P8", SLOT(landmark.ring_radius_mm)},
    ConfigKey{"landmark", "dot_diameter_mm", "mm", kMinLength_mm, kMaxLength_mm, "", "of P1..P8; dots must not touch",
              SLOT(landmark.dot_diameter_mm)},
    ConfigKey{"landmark", "centre_diameter_mm", "mm", kMinLength_mm, kMaxLength_mm, "", "of P9, the largest dot",
              SLOT(landmark.centre_diameter_mm)},
    ConfigKey{"landmark", "expected_roll_deg", "deg", -180, 180, "",
              "roll of the camera about its optical axis at which P1 is the lowest dot",
              SLOT(landmark.expected_roll_deg)},
    ConfigKey{
        "landmark", "roll_sigma_deg", "deg", 0.1, 90, "",
        "1-sigma of the camera's roll about `expected_roll_deg`: how level it is mounted and stays; the ring looks "
        "alike after 45 deg, and a roll of more than four of these leaves open which dot is P1",
        SLOT(landmark.roll_sigma_deg)},

    ConfigKey{"landmarks", "id", "", 0, 65535, "", "number in reports, unique; must be given", LANDMARK_SLOT(id)},
    ConfigKey{
        "landmarks", "code", "", 0, 0, "",
        "colours of P1..P8, eight of K (black) R G B, different from every turn of itself and of the others; empty = "
        "black and white",
        LANDMARK_SLOT(code)},
    ConfigKey{
        "landmarks", "position_mm", "mm", -kMaxPosition_mm, kMaxPosition_mm, "",
        "[x, y, z] of the middle of P9 in the world, Z up; none = its place is unknown (`ninedot map` finds it), a "
        "lone landmark's is the world's origin",
        LANDMARK_SLOT(position_mm)},
    ConfigKey{"landmarks", "heading_deg", "deg", -360, 360, "", "turn of the upright sheet about the world's Z",
              LANDMARK_SLOT(heading_deg)},
    ConfigKey{
        "landmarks", "orientation_wxyz", "", -1, 1, "",
        "in place of `heading_deg`, for sheets that are not upright: [w, x, y, z], the unit quaternion that turns "
        "the sheet's axes into the world's",
        LANDMARK_SLOT(orientation_wxyz)},
    ConfigKey{"landmarks", "sigma_position_mm", "mm", 0, kMaxSigma_mm, "",
              "1-sigma of the position along the world's X, Y, Z; 0 = exact", LANDMARK_SLOT(sigma_position_mm)},
    ConfigKey{"landmarks", "sigma_rotation_deg", "deg", 0, 180, "",
              "1-sigma of the orientation about the world's X, Y, Z; 0 = exact", LANDMARK_SLOT(sigma_rotation_deg)},
    ConfigKey{
        "landmarks", "from_pictures", "", 0, 0, "",
        "`ninedot map` found this place, and finds it anew when it makes the map again; false = somebody measured it",
        LANDMARK_SLOT(from_pictures)},

    ConfigKey{"pose", "solver", "", 0, 0, "full|ellipse",
              "`full`: near the maximum likelihood; `ellipse`: the founding paper's", SLOT(pose.solver)},
    ConfigKey{"pose", "tracking", "", 0, 0, "", "look where the landmark was before searching the whole picture",
              SLOT(pose.tracking)},
    ConfigKey{"pose", "max_ambiguity", "", 0, 1, "",
              "odds that another reading of the picture (mirror image, numbering of the dots) is the right one, above "
              "which a pose is not valid",
              SLOT(pose.max_ambiguity)},
    ConfigKey{"pose", "max_sigma_percent", "%", 0.01, 10, "",
              "1-sigma of the position, all axes together, above which a pose is not valid; of the distance",
              SLOT(pose.max_sigma_percent)},
    ConfigKey{"pose", "main_landmark", "", 0, 0, "nearest|surest",
              "of several landmarks in view the one whose pose is reported, among those that are valid: the `nearest`, "
              "or the `surest`, whose 1-sigma of the position is smallest",
              SLOT(pose.main_landmark)},

    ConfigKey{"pose.ellipse", "kmm_mm_per_px", "mm/px", 0, 1, "", "Kmm of equation (6); 0 = of the calibrated camera",
              SLOT(ellipse.kmm_mm_per_px)},
    ConfigKey{"pose.ellipse", "p1", "mm/px", -1, 1, "", "F(D') = p1 + p2 D'^p3 (9), D' in mm; 0 = no refinement",
              SLOT(ellipse.p1)},
    ConfigKey{"pose.ellipse", "p2", "", -1e6, 1e6, "", "of the same", SLOT(ellipse.p2)},
    ConfigKey{"pose.ellipse", "p3", "", -10, 10, "", "of the same", SLOT(ellipse.p3)},
    ConfigKey{"pose.ellipse", "cu", "", -1, 1, "", "off-centre correction along u (32)", SLOT(ellipse.cu)},
    ConfigKey{"pose.ellipse", "cv", "", -1, 1, "", "off-centre correction along v (33)", SLOT(ellipse.cv)},

    ConfigKey{"track", "acceleration_sigma_m_s2", "m/s^2", 0.001, 100, "",
              "1-sigma of the robot's usual accelerations, each axis, that last for a quarter of a second; smaller is "
              "smoother, and lags a few pictures when the robot does more",
              SLOT(track.acceleration_sigma_m_s2)},
    ConfigKey{"track", "angular_acceleration_sigma_deg_s2", "deg/s^2", 0.1, 1e5, "",
              "likewise of the robot's turns; a head's own, `slew_deg_per_s` within that time, come on top",
              SLOT(track.angular_acceleration_sigma_deg_s2)},
    ConfigKey{"track", "common_share", "", 0, 0.9, "",
              "of a frame's variance the share that consecutive frames have in common, and that averaging leaves",
              SLOT(track.common_share)},

    ConfigKey{"body", "pan_axis_mm", "mm", -kMaxLength_mm, kMaxLength_mm, "",
              "[x, y, z] of a point of the head's pan axis; of the camera where there is no head",
              SLOT(body.pan_axis_mm)},
    ConfigKey{"body", "mount_rpy_deg", "deg", -180, 180, "",
              "[roll, pitch, yaw] of the head's foot, or of the camera: turns about x, then y, then z of the body; a "
              "positive pitch looks down",
              SLOT(body.mount_rpy_deg)},
    ConfigKey{"body", "tilt_axis_mm", "mm", -kMaxLength_mm, kMaxLength_mm, "",
              "[x, y, z] of a point of the tilt axis from that of the pan axis, as the head stands at pan 0",
              SLOT(body.tilt_axis_mm)},
    ConfigKey{"body", "camera_mm", "mm", -kMaxLength_mm, kMaxLength_mm, "",
              "[x, y, z] of the optical centre from that point of the tilt axis, at pan 0 and tilt 0",
              SLOT(body.camera_mm)},
    ConfigKey{"body", "camera_rpy_deg", "deg", -180, 180, "",
              "[roll, pitch, yaw] of the camera on the head, from straight ahead and level at pan 0 and tilt 0",
              SLOT(body.camera_rpy_deg)},
    ConfigKey{"body", "pan_sigma_deg", "deg", 0, 30, "",
              "1-sigma of the pan angle that the head tells: encoder, dead band, play", SLOT(body.pan_sigma_deg)},
    ConfigKey{"body", "tilt_sigma_deg", "deg", 0, 30, "", "likewise of the tilt angle", SLOT(body.tilt_sigma_deg)},
    ConfigKey{"body", "mount_sigma_mm", "mm", 0, kMaxLength_mm, "",
              "1-sigma of the camera's place on the body, each axis", SLOT(body.mount_sigma_mm)},
    ConfigKey{"body", "mount_sigma_deg", "deg", 0, 30, "", "1-sigma of its orientation, each axis",
              SLOT(body.mount_sigma_deg)},

};

const std::array kKeysAfterTheHead{
    ConfigKey{"gpio", "servo_power", "", 0, 0, "",
              "output: active while the head may be driven; a line's name, or chip label and offset `LABEL:OFFSET`",
              SLOT(gpio.servo_power)},
    ConfigKey{"gpio", "servo_power_active_low", "", 0, 0, "", "low = the servos have power",
              SLOT(gpio.servo_power_active_low)},
    ConfigKey{"gpio", "status_led", "", 0, 0, "", "output: blinks what is the matter, see docs/pan-tilt.md",
              SLOT(gpio.status_led)},
    ConfigKey{"gpio", "status_led_active_low", "", 0, 0, "", "low = lit", SLOT(gpio.status_led_active_low)},
    ConfigKey{"gpio", "inhibit", "", 0, 0, "", "input: while it is active the head does not move", SLOT(gpio.inhibit)},
    ConfigKey{"gpio", "inhibit_active_low", "", 0, 0, "", "low = the head must not move",
              SLOT(gpio.inhibit_active_low)},
    ConfigKey{"gpio", "inhibit_bias", "", 0, 0, "unchanged|pull-up|pull-down",
              "resistor inside the chip, if it has one", SLOT(gpio.inhibit_bias)},

    ConfigKey{"modbus", "position_scale_16bit_mm", "mm", 0.01, 100, "", "one step of the 16-bit x, y, z",
              SLOT(modbus.position_scale_16bit_mm)},
    ConfigKey{"modbus", "float_word_order", "", 0, 0, "high-first|low-first", "which half of a float32 comes first",
              SLOT(modbus.float_word_order)},
    ConfigKey{"modbus", "allow_writes", "", 0, 0, "", "take commands by function codes 06 and 16",
              SLOT(modbus.allow_writes)},
    ConfigKey{"modbus", "hold_ms", "ms", 10, 10000, "", "HOLD releases itself after this time", SLOT(modbus.hold_ms)},

    ConfigKey{"modbus.tcp", "listen", "", 0, 0, "", "IPv4 or IPv6 address; 0.0.0.0 = on all networks",
              SLOT(modbus_tcp.listen)},
    ConfigKey{"modbus.tcp", "port", "", 1, 65535, "", "TCP port; below 1024 only with CAP_NET_BIND_SERVICE",
              SLOT(modbus_tcp.port)},
    ConfigKey{"modbus.tcp", "max_clients", "", 1, 64, "", "connections at a time", SLOT(modbus_tcp.max_clients)},
    ConfigKey{"modbus.tcp", "idle_timeout_s", "s", 1, 86400, "",
              "a connection without a request is closed after this time", SLOT(modbus_tcp.idle_timeout_s)},
    ConfigKey{"modbus.tcp", "allow", "", 0, 0, "",
              "addresses, or networks like `10.0.0.0/8`, that may connect; empty = all", SLOT(modbus_tcp.allow)},

    ConfigKey{"modbus.rtu", "device", "", 0, 0, "", "serial port", SLOT(modbus_rtu.device)},
    ConfigKey{"modbus.rtu", "baud", "", 1200, 921600, "", "one of the standard rates", SLOT(modbus_rtu.baud)},
    ConfigKey{"modbus.rtu", "parity", "", 0, 0, "N|E|O", "none, even or odd; one stop bit", SLOT(modbus_rtu.parity)},
    ConfigKey{"modbus.rtu", "unit", "", 1, 247, "", "this device's address on the line", SLOT(modbus_rtu.unit)},

    ConfigKey{"outputs", "pose", "", 0, 0, "camera_in_world|camera_in_landmark|body_in_world",
              "what the pose registers carry; `body_in_world` needs a landmark with a place, see docs/world.md",
              SLOT(outputs.pose)},
    ConfigKey{"outputs", "euler", "", 0, 0, "zyx|fanuc|kuka",
              "the angles of registers 127-144: yaw, pitch, roll; FANUC W, P, R; KUKA A, B, C", SLOT(outputs.euler)},

    ConfigKey{"tap", "enabled", "", 0, 0, "",
              "give the newest frame and what was found in it to other programs of this machine, see docs/tap.md",
              SLOT(tap.enabled)},
    ConfigKey{"tap", "path", "", 0, 0, "",
              "the file of the shared memory; its folder must be in memory and belong to the service, and its group "
              "may read",
              SLOT(tap.path)},

    ConfigKey{"web", "listen", "", 0, 0, "",
              "IPv4 or IPv6 address; any but this machine's own, 127.0.0.1 or ::1, needs a `token_file`",
              SLOT(web.listen)},
    ConfigKey{"web", "port", "", 1, 65535, "", "TCP port", SLOT(web.port)},
    ConfigKey{"web", "names", "", 0, 0, "",
              "names by which browsers call this machine (`sensor7.plant.example`); its addresses and `localhost` "
              "need no entry",
              SLOT(web.names)},
    ConfigKey{"web", "token_file", "", 0, 0, "",
              "file of mode 600 with one line of 32 characters or more, which the page asks for; empty = everybody "
              "who can connect may look, and nobody may turn the head or record",
              SLOT(web.token_file)},
    ConfigKey{"web", "certificate", "", 0, 0, "", "PEM file, for TLS; empty = no TLS", SLOT(web.certificate)},
    ConfigKey{"web", "key", "", 0, 0, "", "PEM file of its private key, of mode 600", SLOT(web.key)},
    ConfigKey{"web", "pictures_per_s", "Hz", 0.5, 12, "", "pictures and reports per second, at most",
              SLOT(web.pictures_per_s)},
    ConfigKey{
        "web", "ar_pictures_per_s", "Hz", 0.5, 60, "",
        "those of the view AR, at most: each frame of a camera that is no faster, while somebody looks at it; what "
        "that costs: docs/page.md",
        SLOT(web.ar_pictures_per_s)},
    ConfigKey{"web", "quality", "", 20, 95, "", "of the JPEG pictures", SLOT(web.quality)},
    ConfigKey{
        "web", "recordings", "", 0, 0, "",
        "folder of the recordings that the page makes, `/var/lib/ninedot-web` under systemd; empty = none are made",
        SLOT(web.recordings)},
    ConfigKey{"web", "recordings_mb", "MB", 10, 1000000, "", "room for all of them together", SLOT(web.recordings_mb)},
    ConfigKey{"web", "recording_s", "s", 1, 3600, "", "after so long one ends by itself", SLOT(web.recording_s)},
    ConfigKey{"web", "loss_seconds", "s", 0, 30, "",
              "the last seconds before each loss of the landmark become a recording, with one second after it; 0 = off",
              SLOT(web.loss_seconds)},
    ConfigKey{"web", "losses", "", 1, 100, "", "recordings of losses that are kept: the oldest go", SLOT(web.losses)},

    ConfigKey{"service", "realtime_priority", "", 0, 99, "", "SCHED_FIFO priority of the frame loop; 0 = off",
              SLOT(service.realtime_priority)},
    ConfigKey{"service", "lock_memory", "", 0, 0, "", "keep the service in memory (mlockall)",
              SLOT(service.lock_memory)},
};
#undef LANDMARK_SLOT
#undef SLOT

struct TableMeaning {
  std::string_view table, meaning;
};
constexpr std::array kTables{
    TableMeaning{"", "Above all tables."},
    TableMeaning{"camera", "The camera, or what stands in for it."},
    TableMeaning{"landmark", "The geometry that all landmarks share."},
    TableMeaning{"landmarks",
                 "The map: one table `[[landmarks]]` for each landmark. None = one black-and-white landmark, id 0, at "
                 "the world's origin. Upright on a wall is heading 0."},
    TableMeaning{"pose", "How the pose is computed."},
    TableMeaning{"pose.ellipse", "What the founding paper calibrates off line, for `solver = \"ellipse\"`."},
    TableMeaning{"track", "How the camera's pose in the world is followed over time."},
    TableMeaning{
        "body",
        "Where the camera sits on the robot: x forward, y left, z up. None = the camera's optical centre is the "
        "body's origin, and it looks along x."},
    TableMeaning{"pan_tilt", "The pan/tilt head: see docs/pan-tilt.md."},
    TableMeaning{"pan_tilt.pan", "Its lower axis. Angles are positive to the left."},
    TableMeaning{"pan_tilt.tilt", "Its upper axis. Angles are positive upwards."},
    TableMeaning{"gpio", "Single digital lines. An empty name = there is none."},
    TableMeaning{"modbus", "What both Modbus servers share."},
    TableMeaning{"modbus.tcp", "Modbus TCP; served when the table is there, be it empty."},
    TableMeaning{"modbus.rtu", "Modbus RTU on a serial line; served when the table is there, be it empty."},
    TableMeaning{"outputs", "What of the pose others are told."},
    TableMeaning{"tap", "What other programs of this machine may see: `ninedot tap`, the page."},
    TableMeaning{"web", "The page, served by `ninedot-web`; it needs the tap, see docs/page.md."},
    TableMeaning{"service", "How `ninedotd` runs."},
    TableMeaning{"simulation",
                 "A scenario, for `ninedot simulate` and for `source = \"simulated\"`: see docs/simulation.md."},
    TableMeaning{"simulation.robot",
                 "A way-point of the robot: one table `[[simulation.robot]]` for each, straight lines between them. "
                 "Without `[body]` the axes of the head meet in the body's origin."},
    TableMeaning{"simulation.hidden", "A time during which everything is covered; one table for each."},
    TableMeaning{"simulation.servo", "How the two axes of the simulated head truly move."},
    TableMeaning{
        "simulation.head",
        "How the simulated head is truly made, where that is not what `[body]` and `[pan_tilt]` say of it: for "
        "trying what a wrong configuration does, and calibrations."},
};

/// One in each list, for their keys' slots.
Config config_with_entries() {
  Config config;
  config.landmarks.emplace_back();
  config.simulation.robot.emplace_back();
  config.simulation.hidden.emplace_back();
  return config;
}

std::string heading_of(std::string_view table) {
  if (table.empty()) return "At the top";
  return is_config_list(table) ? fmt::format("[[{}]]", table) : fmt::format("[{}]", table);
}

constexpr std::string_view kIntroduction = R"(# Configuration

One TOML file. It is read strictly: an unknown, repeated or out-of-range key is an error that names its line, and so is a
landmark whose dots touch. `ninedot check --config FILE` says what the service would refuse, before the service is started.
Every key may be left out unless its line says otherwise.

This page is made from the table in `firmware/config/config_reference.cpp`; a test compares the two.
)";

}  // namespace

std::span<const ConfigKey> config_keys() {
  static const std::vector<ConfigKey> keys = [] {
    std::vector<ConfigKey> all(kKeysUpToTheHead.begin(), kKeysUpToTheHead.end());
    const auto add = [&](std::span<const ConfigKey> part) { all.insert(all.end(), part.begin(), part.end()); };
    add(head_keys());
    add(kKeysAfterTheHead);
    add(simulation_keys());
    return all;
  }();
  return keys;
}

std::string_view config_table_meaning(std::string_view table) {
  for (const TableMeaning& entry : kTables)
    if (entry.table == table) return entry.meaning;
  return {};
}

bool is_config_list(std::string_view table) noexcept {
  return table == "landmarks" || table == "simulation.robot" || table == "simulation.hidden";
}

std::string config_key_default(const ConfigKey& key) {
  Config config = config_with_entries();
  struct Printer {
    std::string operator()(const bool* value) const { return *value ? "true" : "false"; }
    std::string operator()(const int* value) const { return fmt::format("{}", *value); }
    std::string operator()(const std::uint16_t* value) const { return fmt::format("{}", *value); }
    std::string operator()(const std::uint32_t* value) const { return fmt::format("{}", *value); }
    std::string operator()(const double* value) const { return fmt::format("{}", *value); }
    std::string operator()(const char* value) const { return fmt::format("\"{}\"", *value); }
    std::string operator()(const std::string* value) const { return fmt::format("\"{}\"", *value); }
    std::string operator()(const std::vector<std::string>*) const { return "[]"; }
    std::string operator()(const std::array<double, 3>*) const { return "[0, 0, 0]"; }
    std::string operator()(const std::optional<double>*) const { return "none"; }
    std::string operator()(const std::optional<std::array<double, 3>>*) const { return "none"; }
    std::string operator()(const std::optional<std::array<double, 4>>*) const { return "none"; }
    std::string operator()(const std::vector<AxisPoint>*) const { return "[]"; }
  };
  return std::visit(Printer{}, key.slot(config));
}

std::string config_key_range(const ConfigKey& key) {
  if (!key.choices.empty()) {
    std::string text;
    for (const char c : key.choices) text += c == '|' ? std::string(", ") : std::string(1, c);
    return text;
  }
  Config config = config_with_entries();
  struct Printer {
    const ConfigKey& key;
    std::string numbers() const { return fmt::format("{} .. {}", key.min, key.max); }
    std::string operator()(const bool*) const { return "true, false"; }
    std::string operator()(const int*) const { return numbers(); }
    std::string operator()(const std::uint16_t*) const { return numbers(); }
    std::string operator()(const std::uint32_t*) const { return numbers(); }
    std::string operator()(const double*) const { return numbers(); }
    std::string operator()(const char*) const { return "letter"; }
    std::string operator()(const std::string*) const { return "text"; }
    std::string operator()(const std::vector<std::string>*) const { return "list of texts"; }
    std::string operator()(const std::array<double, 3>*) const { return "three, each " + numbers(); }
    std::string operator()(const std::optional<double>*) const { return numbers(); }
    std::string operator()(const std::optional<std::array<double, 3>>*) const { return "three, each " + numbers(); }
    std::string operator()(const std::optional<std::array<double, 4>>*) const { return "four, each " + numbers(); }
    std::string operator()(const std::vector<AxisPoint>*) const { return "list of pairs"; }
  };
  return std::visit(Printer{key}, key.slot(config));
}

std::string format_config_reference() {
  std::string text(kIntroduction);
  std::optional<std::string_view> table;
  for (const ConfigKey& key : config_keys()) {
    if (key.table != table) {
      table = key.table;
      text += fmt::format("\n## {}\n\n{}\n\n| key | unit | range | default | meaning |\n|---|---|---|---|---|\n",
                          heading_of(key.table), config_table_meaning(key.table));
    }
    text += fmt::format("| `{}` | {} | {} | `{}` | {} |\n", key.name, key.unit, config_key_range(key),
                        config_key_default(key), key.meaning);
  }
  return text;
}

}  // namespace ninedot
