#include <arpa/inet.h>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <filesystem>
#include <fstream>

#include "base/startup_error.h"
#include "programs/commands/commands.h"
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

  TemporaryRecording folder_{0};
};

TEST_F(Commands, CheckSaysOkWithASummary) {
  const Outcome outcome = check(camera());
  EXPECT_EQ(outcome.status, ExitStatus::kSuccess) << outcome.line;
  EXPECT_EQ(outcome.line.substr(0, outcome.line.find('\n')), folder_.path() + "/c.toml: ok");
  EXPECT_NE(outcome.line.find("640x480"), std::string::npos);
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
  EXPECT_EQ(refusal("[camera]\nsource = \"simulated\""),
            "c.toml:2: camera.source is 'simulated', but this build has only recording, v4l2, libcamera");
  EXPECT_EQ(refusal("[camera]\n"),
            "c.toml:1: camera.device is missing: write the recording's folder or .y4m file into the configuration");
  EXPECT_EQ(refusal(camera() + "calibration = \"/nowhere.yaml\""),
            "c.toml:3: /nowhere.yaml: no such calibration; set camera.calibration");
  EXPECT_NE(refusal(camera() + "width_px = 320").find("is for 640 x 480 px, but the camera gives 320 x 480"),
            std::string::npos);
  EXPECT_EQ(refusal(camera() + "[modbus.rtu]\ndevice = \"/dev/nowhere\""),
            "c.toml:4: /dev/nowhere: No such file or directory");
  EXPECT_EQ(refusal(camera() + "[modbus.rtu]\ndevice = \"" + kApproach + "\""),
            "c.toml:4: " + kApproach + ": is no serial device");
  EXPECT_EQ(refusal(camera() + "[modbus.tcp]\nlisten = \"203.0.113.7\""),
            "c.toml:4: 203.0.113.7 port 1502: Cannot assign requested address");
  EXPECT_EQ(refusal(camera() + "[[landmarks]]\nid = 1\ncode = \"KRGBKKRB\"").substr(0, 9), "c.toml:3:");
}

TEST_F(Commands, CheckFindsAPortInUse) {
  const int server = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  ASSERT_EQ(::bind(server, reinterpret_cast<sockaddr*>(&address), size), 0);
  ASSERT_EQ(::listen(server, 1), 0);
  ASSERT_EQ(::getsockname(server, reinterpret_cast<sockaddr*>(&address), &size), 0);
  const std::string text = camera() + fmt::format("[modbus.tcp]\nport = {}", ntohs(address.sin_port));
  EXPECT_NE(refusal(text).find("Address already in use: stop the program that uses it"), std::string::npos);
  ::close(server);
  EXPECT_EQ(check(text).status, ExitStatus::kSuccess);
}

TEST_F(Commands, RecordTakesEveryFrameOfARecording) {
  const std::string out = folder_.path() + "/out";
  const Outcome outcome = run({"record", "--config", config(camera()), "--out", out});
  EXPECT_EQ(outcome.line, out + ": 22 frames\n");
  EXPECT_TRUE(fs::exists(out + "/camera.yaml"));
  EXPECT_TRUE(fs::exists(out + "/frames/000021.png"));
  EXPECT_EQ(check(camera(out)).status, ExitStatus::kSuccess);
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
