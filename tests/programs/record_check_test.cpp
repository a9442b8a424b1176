#include <arpa/inet.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <array>
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <sstream>
#include <thread>

#include "base/startup_error.h"
#include "drivers/modbus/server.h"
#include "drivers/posix/file_descriptor.h"
#include "programs/commands/commands.h"
#include "tests/proto/wire_box.h"
#include "tests/recording/temporary_recording.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

struct Outcome {
  ExitStatus status = ExitStatus::kSuccess;
  std::string line;  ///< of the error, or all standard output
};

/// One sub-command as `main` runs it.
Outcome run(std::vector<std::string> arguments) {
  CLI::App app;
  add_record_command(app);
  add_check_command(app);
  std::ranges::reverse(arguments);
  testing::internal::CaptureStdout();
  Outcome outcome;
  try {
    app.parse(arguments);
    outcome.line = testing::internal::GetCapturedStdout();
  } catch (const StartupError& error) {
    testing::internal::GetCapturedStdout();
    outcome = {error.status, error.what()};
  }
  return outcome;
}

const std::string kApproach = std::string(NINEDOT_SOURCE_DIR) + "/tests/recordings/approach";

class Commands : public testing::Test {
 protected:
  std::string config(const std::string& text) {
    folder_.write("c.toml", text);
    return folder_.path() + "/c.toml";
  }
  std::string camera(const std::string& device = kApproach) {
    return fmt::format("[camera]\ndevice = \"{}\"\n", device);
  }
  Outcome check(const std::string& text) { return run({"check", "--config", config(text)}); }
  /// The refusal with its line, without the folder's name in front.
  std::string refusal(const std::string& text) {
    const Outcome outcome = check(text);
    EXPECT_EQ(outcome.status, ExitStatus::kWrongUsage);
    EXPECT_EQ(outcome.line.find('\n'), std::string::npos);
    return outcome.line.substr(std::min(outcome.line.size(), folder_.path().size() + 1));
  }

  /// One line for each, likewise.
  std::vector<std::string> refusals(const std::string& text) {
    const Outcome outcome = check(text);
    EXPECT_EQ(outcome.status, ExitStatus::kWrongUsage);
    std::vector<std::string> lines;
    std::istringstream all(outcome.line);
    for (std::string line; std::getline(all, line);)
      lines.push_back(line.substr(std::min(line.size(), folder_.path().size() + 1)));
    return lines;
  }

  TemporaryRecording folder_{0};
};

/// Lets this process go by the service's name.
class CalledNinedotd {
 public:
  CalledNinedotd() {
    ::prctl(PR_GET_NAME, before_.data());
    ::prctl(PR_SET_NAME, "ninedotd");
  }
  ~CalledNinedotd() { ::prctl(PR_SET_NAME, before_.data()); }
  CalledNinedotd(const CalledNinedotd&) = delete;
  CalledNinedotd& operator=(const CalledNinedotd&) = delete;

 private:
  std::array<char, 16> before_{};
};

TEST_F(Commands, CheckSaysOkWithASummary) {
  const Outcome outcome = check(camera());
  EXPECT_EQ(outcome.status, ExitStatus::kSuccess) << outcome.line;
  EXPECT_EQ(outcome.line.substr(0, outcome.line.find('\n')), folder_.path() + "/c.toml: ok");
  EXPECT_NE(outcome.line.find("640x480"), std::string::npos);
  EXPECT_EQ(outcome.line.find("note:"), std::string::npos) << outcome.line;
}

TEST_F(Commands, CheckAcceptsTheDefaultConfigurationOnItsRecording) {
  std::ifstream shipped(std::string(NINEDOT_SOURCE_DIR) + "/systemd/ninedot.toml");
  std::string text(std::istreambuf_iterator<char>(shipped), {});
  const std::string installed = "/usr/share/ninedot/recordings/approach";
  ASSERT_NE(text.find(installed), std::string::npos);
  text.replace(text.find(installed), installed.size(), kApproach);
  const std::string port = "port = 1502";
  ASSERT_NE(text.find(port), std::string::npos);
  text.replace(text.find(port), port.size(), "port = 47103");  // a service may be running on this machine
  const Outcome outcome = check(text);
  EXPECT_EQ(outcome.status, ExitStatus::kSuccess) << outcome.line;
}

TEST_F(Commands, CheckNamesTheLineOfWhatTheServiceWouldRefuse) {
  EXPECT_EQ(refusal("[camera]\ndevice = \"/nowhere\""), "c.toml:2: /nowhere: no such recording");
  EXPECT_EQ(refusal("[camera]\n\nrate = 3"), "c.toml:3: unknown key 'rate' in [camera]; did you mean 'rate_hz'?");
  EXPECT_EQ(
      refusal("[camera]\nsource = \"simulated\""),
      "c.toml:2: 'source' is 'simulated', and there is no robot: write [[simulation.robot]], where it is and when");
  EXPECT_EQ(refusal("[camera]\n"),
            "c.toml:1: camera.device is missing: write the recording's folder or .y4m file into the configuration");
  EXPECT_EQ(refusal(camera() + "calibration = \"/nowhere.yaml\""),
            "c.toml:3: /nowhere.yaml: no such calibration; set camera.calibration");
  EXPECT_NE(refusal(camera() + "width_px = 320").find("is for 640 x 480 px, but the camera gives 320 x 480"),
            std::string::npos);
  for (const char* device : {kApproach.c_str(), "/dev/null"})
    EXPECT_NE(refusal(camera() + fmt::format("[modbus.rtu]\ndevice = \"{}\"", device))
                  .find(fmt::format("c.toml:4: {}: Inappropriate ioctl for device; this is no serial line", device)),
              std::string::npos);
  EXPECT_EQ(refusal(camera() + "[modbus.tcp]\nlisten = \"203.0.113.7\""),
            "c.toml:4: 203.0.113.7 port 1502: Cannot assign requested address");
  EXPECT_EQ(refusal(camera() + "[[landmarks]]\nid = 1\ncode = \"RRRRRRRR\"").substr(0, 9), "c.toml:5:");
}

TEST_F(Commands, CheckSaysAllThatIsWrongInTheOrderOfTheFile) {
  EXPECT_EQ(refusals("[camera]\ndevice = \"/nowhere\"\ncalibration = \"/nowhere.yaml\"\n[pose]\nrate = 3\nsolver = "
                     "\"none\"\n[modbus.rtu]\nbaud = 9601\n[modbus.tcp]\nlisten = \"203.0.113.7\"\n"),
            (std::vector<std::string>{
                "c.toml:2: /nowhere: no such recording",
                "c.toml:3: /nowhere.yaml: no such calibration; set camera.calibration",
                "c.toml:5: unknown key 'rate' in [pose]",
                "c.toml:6: 'solver' is 'none'; write one of full, ellipse",
                "c.toml:8: 'baud' is 9601; write one of 1200, 2400, 4800, 9600, 19200, 38400, 57600, 115200, 230400, "
                "460800, 500000, 576000, 921600",
            }));
}

TEST_F(Commands, CheckAsksNothingOfATableWhoseKeysItCouldNotRead) {
  EXPECT_EQ(refusals("[camera]\ndevise = \"" + kApproach + "\"\n"),
            (std::vector<std::string>{"c.toml:2: unknown key 'devise' in [camera]; did you mean 'device'?"}));
}

TEST_F(Commands, CheckMakesNoSimulatedCameraOfAHeadThatCannotBe) {
  const std::string simulated = "[camera]\nsource = \"simulated\"\n[pan_tilt]\ndriver = \"simulated\"\n";
  const std::string robot = "[[simulation.robot]]\nt_s = 0\ny_mm = 1100\nheading_deg = -90\n";
  const std::string truth = "[simulation.head]\npan_calibration = [[-60, 2100], [60, 900]]\n";
  ASSERT_EQ(run({"check", "--config", config(simulated + robot + truth)}).status, ExitStatus::kSuccess);
  for (const std::string& mistake : {std::string("[pan_tilt.pan]\nmin_deg = -16\nmax_deg = -16\n"),
                                     std::string("[pan_tilt.pan]\ncalibration = [[-60, 2100], [-60, 900]]\n")}) {
    const Outcome outcome = run({"check", "--config", config(simulated + mistake + robot + truth)});
    EXPECT_EQ(outcome.status, ExitStatus::kWrongUsage) << outcome.line;
  }
  const std::string one_point = "[simulation.head]\npan_calibration = [[-60, 2100]]\n";
  EXPECT_EQ(run({"check", "--config", config(simulated + robot + one_point)}).status, ExitStatus::kWrongUsage);
}

TEST_F(Commands, CheckTakesAMissingDeviceForOneThatMayCome) {
  const Outcome outcome =
      check("[camera]\nsource = \"v4l2\"\ndevice = \"/dev/nowhere\"\ncalibration = \"" + kApproach +
            "/camera.yaml\"\n[pan_tilt]\ndriver = \"visca\"\ndevice = \"/dev/nowhere-else\"\n[gpio]\ninhibit = "
            "\"no-chip:1\"\n[modbus.rtu]\ndevice = \"/dev/no-line\"\n");
  EXPECT_EQ(outcome.status, ExitStatus::kSuccess) << outcome.line;
  for (const char* note :
       {"c.toml:3: note: waits for it: /dev/nowhere: no such camera",
        "c.toml:7: note: waits for it: /dev/nowhere-else: there is no such serial port",
        "c.toml:9: note: waits for it: ", "c.toml:11: note: waits for it: /dev/no-line: No such file"})
    EXPECT_NE(outcome.line.find(note), std::string::npos) << note << " in " << outcome.line;
}

TEST_F(Commands, CheckSaysWhatAHeadOnABusWaitsForAndWhatNoWaitingMends) {
  const auto with_head = [&](const std::string& driver, const std::string& device, const std::string& rest = "") {
    return check(camera() + "[pan_tilt]\ndriver = \"" + driver + "\"\ndevice = \"" + device + "\"\n" + rest);
  };
  for (const char* driver : {"dynamixel", "feetech-sts", "feetech-scs"}) {
    const Outcome absent = with_head(driver, "/dev/nowhere");
    EXPECT_EQ(absent.status, ExitStatus::kSuccess);
    EXPECT_NE(absent.line.find("c.toml:5: note: waits for it: /dev/nowhere: there is no such serial port"),
              std::string::npos)
        << absent.line;
    EXPECT_EQ(with_head(driver, "/dev/null").status, ExitStatus::kWrongUsage) << "no terminal";
  }
  const Outcome absent = with_head("pca9685", "/dev/nowhere", "output_enable = \"no-chip:1\"\n");
  EXPECT_EQ(absent.status, ExitStatus::kSuccess);
  for (const char* note : {"c.toml:5: note: waits for it: /dev/nowhere: there is no such I2C bus",
                           "c.toml:6: note: waits for it: GPIO line 'no-chip:1'"})
    EXPECT_NE(absent.line.find(note), std::string::npos) << note << " in " << absent.line;
  EXPECT_EQ(with_head("pca9685", "/dev/null").status, ExitStatus::kWrongUsage) << "no I2C bus";
  const Outcome period = with_head("pca9685", "/dev/nowhere", "oscillator_hz = 5e7\nperiod_ms = 40\n");
  EXPECT_EQ(period.status, ExitStatus::kWrongUsage);
  EXPECT_NE(period.line.find("c.toml:7: a PCA9685 at 5e+07 Hz has no period of 40 ms"), std::string::npos)
      << period.line;
}

TEST_F(Commands, CheckKnowsOnePortByTwoNames) {
  const FileDescriptor master(::posix_openpt(O_RDWR | O_NOCTTY));
  ASSERT_TRUE(::grantpt(master.get()) == 0 && ::unlockpt(master.get()) == 0);
  const std::string port = ::ptsname(master.get()), link = folder_.path() + "/by-id";
  fs::create_symlink(port, link);
  const auto with_head_on = [&](const std::string& device) {
    return camera() + fmt::format("[modbus.rtu]\ndevice = \"{}\"\n[pan_tilt]\ndriver = \"visca\"\ndevice = \"{}\"\n",
                                  port, device);
  };
  EXPECT_EQ(refusal(with_head_on(link)),
            fmt::format("c.toml:7: {} and {} are one port, which serves either [pan_tilt] or [modbus.rtu]; correct one "
                        "of them",
                        link, port));
  EXPECT_EQ(check(with_head_on("/dev/no-such-port")).status, ExitStatus::kSuccess) << "waits for it";
}

TEST_F(Commands, CheckOfTheFileAloneLooksAtNothingElse) {
  const std::string text = "[camera]\ndevice = \"/nowhere\"\n[modbus.tcp]\nlisten = \"203.0.113.7\"\n";
  EXPECT_EQ(run({"check", "--file-only", "--config", config(text)}).status, ExitStatus::kSuccess);
  EXPECT_EQ(check(text).status, ExitStatus::kWrongUsage);
  EXPECT_EQ(run({"check", "--file-only", "--config", config(text + "port = 0\n")}).status, ExitStatus::kWrongUsage);
}

TEST_F(Commands, CheckOfTheFileAloneMissesNothingThatTheFileLeavesOut) {
  const auto refusal_of_file = [&](const std::string& text) {
    const Outcome outcome = run({"check", "--file-only", "--config", config(text)});
    EXPECT_EQ(outcome.status, ExitStatus::kWrongUsage) << text;
    return outcome.line;
  };
  for (const char* source : {"v4l2", "libcamera", "recording"})
    EXPECT_NE(refusal_of_file(fmt::format("[camera]\nsource = \"{}\"\n", source))
                  .find("c.toml:1: camera.device is missing: "),
              std::string::npos);
  EXPECT_NE(refusal_of_file("[camera]\nsource = \"v4l2\"\ndevice = \"/dev/video0\"\n")
                .find("c.toml:1: camera.calibration is missing: "),
            std::string::npos);
  EXPECT_NE(refusal_of_file(camera() + "[pan_tilt]\ndriver = \"visca\"\n").find("c.toml:3: 'device' is empty"),
            std::string::npos);
}

TEST_F(Commands, CheckSaysThatAnOlderFilesWaitForDeviceHasNoEffect) {
  const Outcome outcome = check(camera() + "wait_for_device = false");
  EXPECT_EQ(outcome.status, ExitStatus::kSuccess);
  EXPECT_NE(outcome.line.find("c.toml:3: note: without effect"), std::string::npos) << outcome.line;
}

TEST_F(Commands, CheckKnowsARunningServiceFromAnotherProgramOnItsPort) {
  const test::WireBox source;
  ModbusOptions options;
  options.tcp.emplace().port = 0;
  options.tcp->allow = {"192.0.2.1"};
  const ModbusServer service(source, options);
  const CalledNinedotd name;
  const Outcome outcome = check(camera() + fmt::format("[modbus.tcp]\nport = {}", service.tcp_port()));
  EXPECT_EQ(outcome.status, ExitStatus::kSuccess) << outcome.line;
  EXPECT_NE(outcome.line.find(
                fmt::format("c.toml:4: note: 127.0.0.1 port {} is in use by a running ninedotd", service.tcp_port())),
            std::string::npos)
      << outcome.line;
}

/// Somebody's socket that listens on a port of the loopback interface.
class Listener {
 public:
  Listener() : socket_(::socket(AF_INET, SOCK_STREAM, 0)) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof(address);
    EXPECT_EQ(::bind(socket_.get(), reinterpret_cast<sockaddr*>(&address), size), 0);
    EXPECT_EQ(::listen(socket_.get(), 1), 0);
    EXPECT_EQ(::getsockname(socket_.get(), reinterpret_cast<sockaddr*>(&address), &size), 0);
    port_ = ntohs(address.sin_port);
  }
  std::uint16_t port() const { return port_; }

 private:
  FileDescriptor socket_;
  std::uint16_t port_ = 0;
};

TEST_F(Commands, CheckFindsAPortInUse) {
  const Listener other;
  EXPECT_NE(refusal(camera() + fmt::format("[modbus.tcp]\nport = {}", other.port()))
                .find("Address already in use: stop the program that uses it"),
            std::string::npos);
}

// A service that is being restarted ends while the check looks.
TEST_F(Commands, CheckWaitsForAPortThatIsBeingLetGo) {
  std::optional<Listener> ending(std::in_place);
  const std::string text = camera() + fmt::format("[modbus.tcp]\nport = {}", ending->port());
  std::jthread end([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    ending.reset();
  });
  const Outcome outcome = check(text);
  EXPECT_EQ(outcome.status, ExitStatus::kSuccess) << outcome.line;
}

TEST_F(Commands, RecordTakesEveryFrameOfARecording) {
  const std::string out = folder_.path() + "/out";
  const Outcome outcome = run({"record", "--config", config(camera()), "--out", out});
  EXPECT_EQ(outcome.line, out + ": 22 frames\n");
  EXPECT_TRUE(fs::exists(out + "/camera.yaml"));
  EXPECT_TRUE(fs::exists(out + "/frames/000021.png"));
  EXPECT_EQ(check(camera(out)).status, ExitStatus::kSuccess);
}

TEST_F(Commands, RecordKeepsAllThatTheCalibrationSaysOfItself) {
  std::ifstream own(kApproach + "/camera.yaml");
  const std::string text = std::string(std::istreambuf_iterator<char>(own), {}) +
                           "calibration:\n  date: \"2026-11-22\"\n  camera_id: usb-046d:0825\n  # by hand\n";
  folder_.write("mine.yaml", text);
  const std::string path = config(camera() + "calibration = \"mine.yaml\"\n");
  const Outcome outcome = run({"record", "--config", path, "--out", folder_.path() + "/out", "--frames", "1"});
  EXPECT_EQ(outcome.status, ExitStatus::kSuccess) << outcome.line;
  std::ifstream recorded(folder_.path() + "/out/camera.yaml");
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(recorded), {}), text);
}

TEST_F(Commands, CheckRefusesAFocusPositionThatNothingKeeps) {
  EXPECT_NE(refusal(camera() + "focus_position = 30\n").find("camera.focus_position has no effect"), std::string::npos);
  EXPECT_EQ(check(camera() + "focus_position = 30\nfocus = \"fixed\"\n").status, ExitStatus::kSuccess);
}

TEST_F(Commands, RecordStopsAfterTheFramesAskedFor) {
  const std::string out = folder_.path() + "/out";
  EXPECT_EQ(run({"record", "--config", config(camera()), "--out", out, "--frames", "3"}).line, out + ": 3 frames\n");
  EXPECT_FALSE(fs::exists(out + "/frames/000003.png"));
}

TEST_F(Commands, RecordRefusesAFolderThatIsNotEmpty) {
  const Outcome outcome = run({"record", "--config", config(camera()), "--out", kApproach});
  EXPECT_EQ(outcome.status, ExitStatus::kWrongUsage);
  EXPECT_NE(outcome.line.find("not empty"), std::string::npos);
}

TEST_F(Commands, RecordNamesThePictureThatItCantReadAndLeavesNothingBehind) {
  const TemporaryRecording damaged(1);
  fs::resize_file(damaged.picture(0), 20);
  const std::string out = folder_.path() + "/out";
  const Outcome outcome =
      run({"record", "--config", config(camera(damaged.path()) + "width_px = 16\nheight_px = 16"), "--out", out});
  EXPECT_EQ(outcome.status, ExitStatus::kWorkFailed);
  EXPECT_EQ(outcome.line.find(damaged.picture(0) + ": frame 0: "), 0U) << outcome.line;
  EXPECT_FALSE(fs::exists(out));
}

}  // namespace
}  // namespace ninedot
