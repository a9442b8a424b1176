#include "config/config.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <fstream>
#include <sstream>
#include <type_traits>

#include "base/baud_rates.h"
#include "base/startup_error.h"
#include "config/config_checks.h"
#include "config/config_reference.h"
#include "config_text.h"
#include "programs/assembly/input_files.h"

namespace ninedot {
namespace {

using test::error_of;
using test::parse;

std::vector<std::string> errors_of(const std::string& text) {
  ConfigProblems problems;
  read_config_text(text, "t.toml", problems);
  std::vector<std::string> lines;
  for (const ConfigProblem& problem : problems.list) lines.push_back(problem_text("t.toml", problem));
  return lines;
}

std::string header_of(const ConfigKey& key) {
  if (key.table.empty()) return "";
  const bool is_list = key.table == "landmarks" || key.table == "simulation.robot" || key.table == "simulation.hidden";
  return is_list ? fmt::format("[[{}]]\n", key.table) : fmt::format("[{}]\n", key.table);
}

/// What a table needs beside the key that is tried.
std::string company_of(const ConfigKey& key) {
  if (key.name == "loss_seconds") return "recordings = \"/var/lib/x\"\n";
  if (key.table == "simulation.robot" && key.name != "t_s") return "t_s = 0\n";
  if (key.name == "from_s") return "to_s = 86400\n";
  if (key.name == "to_s") return "from_s = 0\n";
  if (key.table != "landmarks" || key.name == "id") return "";
  return key.name == "position_mm" ? "id = 1\n" : "id = 1\nposition_mm = [0, 0, 0]\n";
}

bool is_single_number(const ConfigKey& key) {
  Config config;
  config.landmarks.emplace_back();
  config.simulation.robot.emplace_back();
  config.simulation.hidden.emplace_back();
  return key.min < key.max &&
         std::visit([](auto slot) { return std::is_arithmetic_v<std::remove_pointer_t<decltype(slot)>>; },
                    key.slot(config));
}

std::string file_text(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  EXPECT_TRUE(stream) << path;
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

TEST(Config, IsTheDefaultWhenTheFileIsEmpty) {
  const Config config = parse("");
  EXPECT_EQ(config.camera.rate_hz, 35.0);
  EXPECT_FALSE(config.modbus_tcp.enabled);
  EXPECT_TRUE(config.landmarks.empty());
}

TEST(Config, ReadsEveryKindOfKey) {
  const Config config = parse(R"(
[camera]
source = "recording"
width_px = 1280
rate_hz = 30
loop = false
[[landmarks]]
id = 7
code = "KRGBKKRB"
position_mm = [1, -2.5, 1200.0]
heading_deg = 90
[[landmarks]]
id = 8
[pose.ellipse]
p3 = -1.5
[modbus]
hold_ms = 250
[modbus.tcp]
port = 502
allow = ["10.0.0.0/8", "fe80::1"]
[modbus.rtu]
parity = "N"
)");
  EXPECT_EQ(config.camera.width_px, 1280);
  EXPECT_EQ(config.camera.rate_hz, 30.0);
  EXPECT_FALSE(config.camera.loop);
  ASSERT_EQ(config.landmarks.size(), 2U);
  EXPECT_EQ(config.landmarks[0].id, 7);
  EXPECT_EQ(config.landmarks[0].code, "KRGBKKRB");
  EXPECT_EQ(config.landmarks[0].position_mm, (std::array{1.0, -2.5, 1200.0}));
  EXPECT_FALSE(config.landmarks[1].position_mm);
  EXPECT_EQ(config.landmarks[0].heading_deg, 90.0);
  EXPECT_EQ(config.ellipse.p3, -1.5);
  EXPECT_EQ(config.modbus.hold_ms, 250U);
  EXPECT_TRUE(config.modbus_tcp.enabled);
  EXPECT_EQ(config.modbus_tcp.port, 502);
  EXPECT_EQ(config.modbus_tcp.allow, (std::vector<std::string>{"10.0.0.0/8", "fe80::1"}));
  EXPECT_TRUE(config.modbus_rtu.enabled);
  EXPECT_EQ(config.modbus_rtu.parity, 'N');
}

TEST(Config, ReadsTheCalibrationOfAnAxis) {
  const Config config = parse(
      "[pan_tilt]\ndriver = \"simulated\"\n[pan_tilt.tilt]\ncalibration = [[-45, 1900], [0, 1520.5], [45, 1100]]");
  ASSERT_EQ(config.pan_tilt.tilt.calibration.size(), 3U);
  EXPECT_EQ(config.pan_tilt.tilt.calibration[1].output, 1520.5);
  EXPECT_EQ(config.pan_tilt.pan.calibration.size(), 0U);
}

TEST(Config, RefusesAHeadThatCanNotBe) {
  const std::string head = "[pan_tilt]\ndriver = \"simulated\"\n[pan_tilt.pan]\n";
  EXPECT_EQ(error_of(head + "min_deg = 5\nmax_deg = 5"), "t.toml:5: 'max_deg' is 5; write more than min_deg = 5");
  EXPECT_EQ(error_of(head + "neutral_deg = 50"), "t.toml:4: 'neutral_deg' is 50; write -45 to 45, min_deg to max_deg");
  EXPECT_NE(error_of(head + "centre_us = 1990\nneutral_deg = 2").find("pulse outside of min_us = 1000"),
            std::string::npos);
  EXPECT_NE(error_of(head + "min_us = 2100").find("write more than min_us = 2100"), std::string::npos);
  EXPECT_NE(error_of("[pan_tilt]\ndriver = \"simulated\"\nperiod_ms = 5\n[pan_tilt.pan]\nmax_us = 2600")
                .find("t.toml:5: 'max_us'"),
            std::string::npos);
  EXPECT_NE(
      error_of(head + "calibration = [[0, 1000], [10, 900], [20, 950]]").find("t.toml:4: 'calibration' is of no use"),
      std::string::npos);
  for (const char* wrong : {"[0, 1000]", "[[0, 1000], [1]]", "[[0, 1000], [1, \"2\"]]", "3"})
    EXPECT_NE(error_of(head + "calibration = " + wrong).find("t.toml:4: 'calibration' must be"), std::string::npos)
        << wrong;
  EXPECT_NE(error_of(head + "calibration = [[0, 1000], [1, 1e9]]").find("write -100000 to"), std::string::npos);
  EXPECT_EQ(error_of("[pan_tilt.pan]\nmin_deg = 60"), "no error") << "without a driver the axes do not matter";
}

TEST(Config, SaysAllThatIsWrongWithAHead) {
  EXPECT_EQ(
      errors_of("[pan_tilt]\ndriver = \"sysfs-pwm\"\n[pan_tilt.pan]\nmin_deg = 5\nmax_deg = 5\n"
                "calibration = [[0, 1000]]\nmax_us = 800\nchannel = 1\n[pan_tilt.tilt]\nneutral_deg = 50\n"
                "max_us = 900\nchip = \"a.pwm\"\n"),
      (std::vector<std::string>{
          "t.toml:3: 'chip' is empty; write the device of the PWM chip, like fe20c000.pwm",
          "t.toml:5: 'max_deg' is 5; write more than min_deg = 5",
          "t.toml:6: 'calibration' is of no use; write 2 to 32 pairs whose angles rise and whose outputs all rise "
          "or all fall",
          "t.toml:7: 'max_us' is 800; write more than min_us = 1000",
          "t.toml:10: 'neutral_deg' is 50; write -45 to 45, min_deg to max_deg",
          "t.toml:11: 'max_us' is 900; write more than min_us = 1000",
      }));
}

TEST(Config, RefusesAHeadWithoutTheNamesOfItsDevices) {
  EXPECT_EQ(errors_of("[pan_tilt]\ndriver = \"gpio\"\n[pan_tilt.pan]\nline = \"\"\n[pan_tilt.tilt]\n"),
            (std::vector<std::string>{
                "t.toml:4: 'line' is empty; write a GPIO line's name, or LABEL:OFFSET",
                "t.toml:5: 'line' is empty; write a GPIO line's name, or LABEL:OFFSET",
            }));
  EXPECT_EQ(error_of("[pan_tilt]\ndriver = \"visca\""), "t.toml:1: 'device' is empty; write the camera's serial port");
}

TEST(Config, RefusesAHeadThatWouldFollowALandmarkThatIsNone) {
  const std::string head = "[pan_tilt]\ndriver = \"simulated\"\nlandmark = \"id\"\nlandmark_id = 7\n";
  EXPECT_EQ(error_of(head), "t.toml:4: 'landmark_id' is 7, and no landmark has that 'id': the head would follow none");
  EXPECT_EQ(error_of(head + "[[landmarks]]\nid = 7\ncode = \"KRGBKKRB\"\n"), "no error");
  EXPECT_EQ(error_of("[pan_tilt]\ndriver = \"simulated\"\nlandmark = \"id\"\n"), "no error") << "the only one is 0";
  EXPECT_EQ(error_of("[pan_tilt]\ndriver = \"none\"\nlandmark = \"id\"\nlandmark_id = 7\n"), "no error");
}

TEST(Config, RefusesAddressesRatesAndNumbersThatAHeadCannotHave) {
  const auto error_with = [](const std::string& driver, const std::string& rest) {
    return error_of("[pan_tilt]\ndriver = \"" + driver + "\"\n" + rest);
  };
  EXPECT_EQ(error_with("pca9685", ""), "t.toml:1: 'device' is empty; write the I2C bus, like /dev/i2c-1");
  EXPECT_EQ(error_with("pca9685", "device = \"/dev/i2c-1\"\naddress = 0x40\n"), "no error");
  EXPECT_EQ(error_with("pca9685", "device = \"/dev/i2c-1\"\n"), "no error");
  EXPECT_EQ(error_with("pca9685", "device = \"/dev/i2c-1\"\naddress = 0x3F\n"),
            "t.toml:4: 'address' is 63; write 0x40 to 0x77");
  EXPECT_EQ(error_with("pca9685", "device = \"/dev/i2c-1\"\n[pan_tilt.pan]\nchannel = 16\n"),
            "t.toml:5: 'channel' is 16; write 0 to 15");
  EXPECT_EQ(
      error_with("pca9685", "device = \"/dev/i2c-1\"\n[pan_tilt.pan]\nchannel = 1\n"),
      "t.toml:1: pan_tilt.tilt.channel and pan_tilt.pan.channel are both 'channel 1'; a device serves one of them");
  EXPECT_EQ(error_with("pca9685", "device = \"/dev/i2c-1\"\noutput_enable = \"a\"\n[gpio]\nservo_power = \"a\"\n"),
            "t.toml:4: pan_tilt.output_enable and gpio.servo_power are both 'a'; a device serves one of them");
  EXPECT_EQ(error_with("visca", "device = \"/dev/ttyUSB0\"\naddress = 8\n"), "t.toml:4: 'address' is 8; write 1 to 7");
  for (const char* maker : {"dynamixel", "feetech-sts", "feetech-scs"}) {
    EXPECT_EQ(error_with(maker, ""), "t.toml:1: 'device' is empty; write the servos' serial port");
    EXPECT_EQ(error_with(maker, "device = \"/dev/ttyUSB0\"\nbaud = 1000000\n"), "no error");
    EXPECT_EQ(error_with(maker, "device = \"/dev/ttyUSB0\"\nbaud = 1200\n").substr(0, 50),
              "t.toml:4: 'baud' is 1200; write one of 9600, 19200");
    EXPECT_EQ(error_with(maker, "device = \"/dev/ttyUSB0\"\n[pan_tilt.tilt]\nid = 1\n"),
              "t.toml:5: pan_tilt.tilt.id and pan_tilt.pan.id are both 'servo 1'; a device serves one of them");
    EXPECT_EQ(error_with(maker, "device = \"/dev/ttyS1\"\n[modbus.rtu]\n").substr(0, 9), "t.toml:4:");
  }
}

TEST(Config, RefusesADeviceThatTwoKeysName) {
  EXPECT_EQ(error_of("[pan_tilt]\ndriver = \"visca\"\ndevice = \"/dev/ttyUSB0\"\n[modbus.rtu]\ndevice = "
                     "\"/dev//ttyUSB0\""),
            "t.toml:5: modbus.rtu.device and pan_tilt.device are both '/dev/ttyUSB0'; a device serves one of them");
  EXPECT_EQ(error_of("[pan_tilt]\ndriver = \"visca\"\ndevice = \"/dev/ttyS1\"\n[modbus.rtu]\n").substr(0, 9),
            "t.toml:4:")
      << "the default";
  EXPECT_EQ(error_of("[pan_tilt]\ndevice = \"/dev/ttyS1\"\n[modbus.rtu]\n"), "no error") << "no head";
  EXPECT_EQ(error_of("[pan_tilt]\ndriver = \"visca\"\ndevice = \"/dev/ttyS1\"\n"), "no error") << "no Modbus RTU";
  EXPECT_EQ(errors_of("[gpio]\ninhibit = \"a:1\"\nstatus_led = \"a:1\"\n[pan_tilt]\ndriver = \"gpio\"\n"
                      "[pan_tilt.pan]\nline = \"b\"\n[pan_tilt.tilt]\nline = \"b\"\n"),
            (std::vector<std::string>{
                "t.toml:3: gpio.status_led and gpio.inhibit are both 'a:1'; a device serves one of them",
                "t.toml:9: pan_tilt.tilt.line and pan_tilt.pan.line are both 'b'; a device serves one of them",
            }));
  EXPECT_EQ(errors_of("[pan_tilt]\ndriver = \"sysfs-pwm\"\n[pan_tilt.pan]\nchip = \"c\"\n[pan_tilt.tilt]\nchip "
                      "= \"c\"\nchannel = 0\n"),
            (std::vector<std::string>{"t.toml:7: pan_tilt.tilt.channel and pan_tilt.pan.channel are both '0 of c'; a "
                                      "device serves one of them"}));
}

TEST(Config, TakesEachKeyAtBothEndsOfItsRangeAndRefusesWhatLiesBeyond) {
  int checked = 0;
  for (const ConfigKey& key : config_keys()) {
    if (!is_single_number(key) || key.table == "landmark" || key.name == "baud") continue;
    const std::string start = header_of(key) + company_of(key);
    const auto with = [&](double value) {
      std::ostringstream text;
      text.precision(17);
      text << start << key.name << " = " << value << "\n";
      return text.str();
    };
    EXPECT_EQ(error_of(with(key.min)), "no error") << with(key.min);
    EXPECT_EQ(error_of(with(key.max)), "no error") << with(key.max);
    EXPECT_NE(error_of(with(key.min - 1)).find("write "), std::string::npos) << with(key.min - 1);
    EXPECT_NE(error_of(with(key.max + 1)).find("write "), std::string::npos) << with(key.max + 1);
    ++checked;
  }
  EXPECT_GT(checked, 20);
}

TEST(Config, KeepsRecordingsInAFolderThatIsNamedWhole) {
  EXPECT_EQ(error_of("[web]\nrecordings = \"/var/lib/x\"\nloss_seconds = 3\n"), "no error");
  EXPECT_EQ(error_of("[web]\nrecordings = \"x\"\n"),
            "t.toml:2: 'recordings' is 'x'; write a folder that begins with /");
  EXPECT_EQ(error_of("[web]\n\nloss_seconds = 3\n"),
            "t.toml:3: 'loss_seconds' needs a folder: write 'recordings' as well");
}

TEST(Config, RefusesNanAndInfinityInEveryNumber) {
  for (const ConfigKey& key : config_keys()) {
    if (!is_single_number(key)) continue;
    for (const std::string value : {"nan", "inf", "-inf"}) {
      EXPECT_NE(
          error_of(fmt::format("{}{}{} = {}", header_of(key), company_of(key), key.name, value)).find("must be a"),
          std::string::npos)
          << key.name;
    }
  }
}

TEST(Config, NamesTheLineAndWhatToWriteInstead) {
  EXPECT_EQ(error_of("[camera]\nrate = 30"), "t.toml:2: unknown key 'rate' in [camera]; did you mean 'rate_hz'?");
  EXPECT_EQ(error_of("[camera]\n\nwidht_px = 30"),
            "t.toml:3: unknown key 'widht_px' in [camera]; did you mean 'width_px'?");
  EXPECT_EQ(error_of("[camera]\nparity = \"E\""),
            "t.toml:2: unknown key 'parity' in [camera]; it belongs to [modbus.rtu]");
  EXPECT_EQ(error_of("[camera]\nxyzzy = 9600"), "t.toml:2: unknown key 'xyzzy' in [camera]");
  EXPECT_EQ(error_of("[camrea]\nrate_hz = 30"), "t.toml:1: unknown table 'camrea'; did you mean 'camera'?");
  EXPECT_EQ(error_of("rate_hz = 30"), "t.toml:1: unknown key 'rate_hz'; it belongs to [camera]");
  EXPECT_EQ(error_of("[camera]\nrate_hz = 300000"), "t.toml:2: 'rate_hz' is 300000; write 0.1 to 100000 Hz");
  EXPECT_EQ(error_of("[camera]\nrate_hz = nan"), "t.toml:2: 'rate_hz' must be a finite number");
  EXPECT_EQ(error_of("[camera]\nwidth_px = 640.0"), "t.toml:2: 'width_px' must be a whole number");
  EXPECT_EQ(error_of("[camera]\nloop = 1"), "t.toml:2: 'loop' must be true or false");
  EXPECT_EQ(error_of("[camera]\nsource = 1"), "t.toml:2: 'source' must be a text in quotes");
  EXPECT_EQ(error_of("[camera]\nsource = \"recordin\""),
            "t.toml:2: 'source' is 'recordin'; write one of libcamera, v4l2, recording, simulated; did you mean "
            "'recording'?");
  EXPECT_EQ(error_of("[modbus.rtu]\nparity = \"X\""), "t.toml:2: 'parity' is 'X'; write one of N, E, O");
  EXPECT_EQ(error_of("[modbus.tcp]\nallow = [1]"), "t.toml:2: 'allow' must be a list of texts, [\"...\", \"...\"]");
  EXPECT_EQ(error_of("[[landmarks]]\nid = 1\nposition_mm = [1, 2]"),
            "t.toml:3: 'position_mm' must be three numbers, [x, y, z]");
  EXPECT_EQ(error_of("[[landmarks]]\nid = 1\nposition_mm = [1, nan, 2]"),
            "t.toml:3: 'position_mm' must be a finite number");
  EXPECT_EQ(error_of("camera = 1"), "t.toml:1: 'camera' is a table; write [camera]");
  EXPECT_EQ(error_of("[landmarks]\nid = 1"), "t.toml:1: 'landmarks' is a list of tables; write [[landmarks]]");
}

TEST(Config, RefusesARepeatedKeyAndBrokenToml) {
  EXPECT_EQ(error_of("[camera]\nrate_hz = 30\nrate_hz = 31").substr(0, 9), "t.toml:3:");
  EXPECT_EQ(error_of("[camera]\n[pose]\n[camera]").substr(0, 9), "t.toml:3:");
  EXPECT_EQ(error_of("[camera\n").substr(0, 9), "t.toml:1:");
  EXPECT_EQ(error_of("[camera]\nrate_hz = ").substr(0, 9), "t.toml:2:");
}

TEST(Config, ReportsTheFirstOfSeveralMistakes) {
  EXPECT_EQ(error_of("[service]\nlock = true\n[camera]\nrate = 30").substr(0, 9), "t.toml:2:");
}

TEST(Config, RefusesDotsThatTouch) {
  EXPECT_EQ(error_of("[landmark]\nring_radius_mm = 80\ndot_diameter_mm = 61.3\ncentre_diameter_mm = 70"),
            "t.toml:3: the dots of the ring touch: dot_diameter_mm must be below 61.2293 for ring_radius_mm = 80");
  EXPECT_EQ(error_of("[landmark]\nring_radius_mm = 30"),
            "t.toml:1: the dots of the ring touch: dot_diameter_mm must be below 22.961 for ring_radius_mm = 30");
  EXPECT_EQ(error_of("[landmark]\ncentre_diameter_mm = 134.6"),
            "t.toml:2: the centre dot touches the ring: centre_diameter_mm must be below 134.6");
  EXPECT_EQ(error_of("[landmark]\ncentre_diameter_mm = 25.4"),
            "t.toml:2: the centre dot must be larger than the others: that is how it is recognised");
  EXPECT_EQ(error_of("[landmark]\nring_radius_mm = 80\ndot_diameter_mm = 40\ncentre_diameter_mm = 70"), "no error");
}

TEST(Config, RefusesAddressesAndRatesThatAreNone) {
  EXPECT_EQ(error_of("[modbus.tcp]\nlisten = \"localhost\""),
            "t.toml:2: 'listen' is 'localhost'; write an IPv4 or IPv6 address");
  EXPECT_EQ(error_of("[modbus.tcp]\nallow = [\"10.0.0.256\"]"),
            "t.toml:2: 'allow' lists '10.0.0.256'; write addresses like 10.0.0.1 or 10.0.0.0/8");
  for (const char* name : {"", "a b", "x/y", "http://a", "sensor:8090", "a\\nb"})
    EXPECT_NE(error_of(fmt::format("[web]\nnames = [\"sensor\", \"{}\"]", name)).find("t.toml:2: 'names' lists '"),
              std::string::npos)
        << name;
  EXPECT_EQ(error_of("[web]\nnames = [\"http://a\"]"),
            "t.toml:2: 'names' lists 'http://a'; write names like sensor.local, without http:// and port");
  EXPECT_EQ(error_of("[web]\nnames = [\"sensor\", \"Sensor_2.local\", \"xn--sensr-hua\", \"10.0.0.1\", \"fe80::1\"]"),
            "no error");
  EXPECT_EQ(
      error_of("[modbus.rtu]\nbaud = 9601"),
      "t.toml:2: 'baud' is 9601; write one of 1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200, 230400, 460800, "
      "500000, 576000, 921600");
  EXPECT_EQ(error_of("[camera]\nsource = \"v4l2\"\nevery_frame = true"),
            "t.toml:3: 'every_frame' is of recordings, and source is v4l2: take it out");
  EXPECT_EQ(error_of("[camera]\npixel_format = \"GREY\"\nblack_level = 64"),
            "t.toml:3: 'black_level' is of Bayer formats, and pixel_format is GREY: take it out");
  for (const char* const format : {"auto", "RGGB", "BGGR12", "GRBG10P", "GBRG10"})
    EXPECT_EQ(error_of(fmt::format("[camera]\npixel_format = \"{}\"\nred_gain = 1.5", format)), "no error") << format;
  for (const int baud : kBaudRates) EXPECT_EQ(error_of(fmt::format("[modbus.rtu]\nbaud = {}", baud)), "no error");
  EXPECT_EQ(error_of("[modbus.rtu]\ndevice = \"\""), "t.toml:2: 'device' is empty");
}

TEST(Config, KeepsItsErrorOnOneLineWhateverTheFileHolds) {
  EXPECT_EQ(error_of("[camera]\n\"a\\nb\" = 1").find('\n'), std::string::npos);
}

TEST(Config, RefusesAFileThatIsNotThere) {
  try {
    read_config("/nonexistent/ninedot.toml");
    FAIL();
  } catch (const StartupError& error) {
    EXPECT_STREQ(error.what(), "/nonexistent/ninedot.toml: cannot be opened: No such file or directory");
  }
}

TEST(Config, ResolvesRelativePathsFromTheFolderOfTheFile) {
  const std::string path = testing::TempDir() + "ninedot_relative.toml";
  std::ofstream(path) << "[camera]\nsource = \"recording\"\ndevice = \"a/b\"\ncalibration = \"../c.yaml\"\n";
  const Config config = read_config(path);
  EXPECT_EQ(config.camera.device, testing::TempDir() + "a/b");
  EXPECT_EQ(config.camera.calibration.find(".."), std::string::npos);
  std::remove(path.c_str());
}

TEST(ConfigReference, IsTheDocumentInDocs) {
  const std::string fresh = std::string(NINEDOT_BINARY_DIR) + "/configuration.md";
  std::ofstream(fresh) << format_config_reference();
  EXPECT_EQ(file_text(std::string(NINEDOT_SOURCE_DIR) + "/docs/configuration.md"), format_config_reference())
      << "docs/configuration.md is not up to date; copy " << fresh;
}

TEST(ConfigReference, HasAMeaningForEveryTableAndKey) {
  for (const ConfigKey& key : config_keys()) {
    EXPECT_FALSE(config_table_meaning(key.table).empty()) << key.table;
    EXPECT_FALSE(key.meaning.empty()) << key.name;
  }
}

TEST(DefaultConfiguration, SaysTheDefaultOfEveryKeyItNames) {
  const Config shipped = read_config(std::string(NINEDOT_SOURCE_DIR) + "/systemd/ninedot.toml");
  EXPECT_EQ(shipped.camera.rate_hz, Config{}.camera.rate_hz);
  EXPECT_EQ(shipped.landmark.ring_radius_mm, Config{}.landmark.ring_radius_mm);
  EXPECT_EQ(shipped.pose.solver, Config{}.pose.solver);
  EXPECT_TRUE(shipped.modbus_tcp.enabled);
  EXPECT_FALSE(shipped.modbus_rtu.enabled);
}

TEST(DefaultConfiguration, CanBeUncommentedLineByLine) {
  std::istringstream lines(file_text(std::string(NINEDOT_SOURCE_DIR) + "/systemd/ninedot.toml"));
  std::string text;
  int uncommented = 0;
  for (std::string line; std::getline(lines, line); text += line + '\n') {
    const bool is_setting =
        line.starts_with("# ") && (line.find(" = ") != std::string::npos || line.starts_with("# ["));
    if (is_setting) line.erase(0, 2), ++uncommented;
  }
  EXPECT_GT(uncommented, 30);
  EXPECT_EQ(error_of(text), "no error") << text;
}

TEST(Config, OutlivesKeysOfDotsWithoutEnd) {
  std::string deep;
  for (int i = 0; i < 100000; ++i) deep += "a.";
  for (const std::string& text : {deep + "b = 1", "[" + deep + "b]", "x = [{" + deep + "b = 1}]", deep + "b = 1\nx = [",
                                  "\n\n" + deep + "b = 1", "# " + deep}) {
    ConfigProblems problems;
    read_config_text(text, "test.toml", problems);
    ASSERT_EQ(problems.list.size(), 1U);
    EXPECT_FALSE(problems.can_be_read);
    EXPECT_EQ(problems.list[0].line, text.starts_with('\n') ? 3 : 1);
  }
}

TEST(Config, TakesListsOfManyNumbersAndAddresses) {
  std::string numbers, addresses;
  for (int i = 0; i < 1000; ++i) numbers += fmt::format("{}[{}.5, {}.5]", i == 0 ? "" : ", ", i, 1000 + i);
  for (int i = 0; i < 250; ++i) addresses += fmt::format("{}\"10.0.{}.1\"", i == 0 ? "" : ", ", i);
  ConfigProblems problems;
  const Config config = read_config_text(
      fmt::format("[pan_tilt.pan]\ncalibration = [{}]\n[modbus.tcp]\nallow = [{}]\n", numbers, addresses), "test.toml",
      problems);
  EXPECT_TRUE(problems.can_be_read);
  EXPECT_EQ(config.modbus_tcp.allow.size(), 250U);
  EXPECT_EQ(config.pan_tilt.pan.calibration.size(), 1000U);
}

TEST(Config, IsInFindsTheTableOfEachMistakeSoonHoweverManyThereAre) {
  std::string text = "[camera]\nrate_hz = 0\n[track]\n";
  for (int i = 0; i < 20000; ++i) text += fmt::format("k{} = 1\n", i);
  ConfigProblems problems;
  read_config_text(text, "test.toml", problems);
  const auto started = std::chrono::steady_clock::now();
  EXPECT_TRUE(problems.is_in("camera"));
  EXPECT_TRUE(problems.is_in("track"));
  EXPECT_FALSE(problems.is_in("modbus"));
  EXPECT_LT(std::chrono::steady_clock::now() - started, std::chrono::seconds(2));
}

}  // namespace
}  // namespace ninedot
