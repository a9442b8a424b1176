// Against a tree of plain files in the shape of /sys/class/pwm; the kernel's own is met in tests/hil.
#include "drivers/servo/sysfs_pwm.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>

#include "base/startup_error.h"
#include "drivers/servo/late_pan_tilt.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr double kDeg = 3.14159265358979 / 180;

class PwmTree {
 public:
  PwmTree() : root_(fs::temp_directory_path() / ("ninedot-pwm-" + std::to_string(::getpid()))) {
    fs::remove_all(root_);
    add_chip("pwmchip0", "fe20d000.pwm", 1);
    add_chip("pwmchip3", "fe20c000.pwm", 2);
  }
  ~PwmTree() { fs::remove_all(root_); }
  std::string root() const { return (root_ / "class").string(); }
  void pull_chip(const std::string& name) const { fs::remove_all(root_ / "class" / name); }
  /// What was written last; the kernel takes each write as a whole, a plain file keeps the rest of a longer one.
  std::string value(const std::string& file) const {
    std::string line;
    std::getline(std::ifstream(root_ / "class" / file) >> std::ws, line);
    return line;
  }

  void add_chip(const std::string& name, const std::string& device, int channels) const {
    const fs::path chip = root_ / "class" / name;
    fs::create_directories(chip);
    fs::create_directories(root_ / "devices" / device);
    std::ofstream(chip / "npwm") << channels << "\n";
    for (const char* file : {"export", "unexport"}) std::ofstream(chip / file) << "";
    for (int i = 0; i < channels; ++i) {
      const fs::path channel = chip / ("pwm" + std::to_string(i));
      fs::create_directories(channel);
      for (const char* file : {"period", "duty_cycle", "enable"}) std::ofstream(channel / file) << "0\n";
    }
    fs::create_directory_symlink("../../devices/" + device, chip / "device");  // last: by this it is found
  }

 private:
  fs::path root_;
};

ServoAxes axes() {
  constexpr std::array kPoints{AxisPoint{-45 * kDeg, 1000}, AxisPoint{45 * kDeg, 2000}};
  return {ServoAxis(kPoints, 1000, 2000), ServoAxis(kPoints, 1100, 1900)};
}

SysfsPanTiltOptions options_for(const PwmTree& tree) {
  SysfsPanTiltOptions options;
  options.root = tree.root();
  options.pan_chip = options.tilt_chip = "fe20c000.pwm";
  return options;
}

std::string refusal(const std::string& root, const std::string& chip, int channel) {
  try {
    check_sysfs_pwm(root, chip, channel);
  } catch (const StartupError& error) {
    EXPECT_EQ(error.status, ExitStatus::kWrongUsage);
    return error.what();
  }
  return "";
}

TEST(SysfsPwm, FindsTheChipByItsDeviceWhateverItsNumber) {
  const PwmTree tree;
  EXPECT_EQ(fs::path(find_pwm_chip(tree.root(), "fe20c000.pwm")).filename(), "pwmchip3");
  EXPECT_EQ(fs::path(find_pwm_chip(tree.root(), "fe20d000.pwm")).filename(), "pwmchip0");
}

TEST(SysfsPwm, NamesTheChipsThatAreThereWhenTheWantedOneIsNot) {
  const PwmTree tree;
  EXPECT_NE(refusal(tree.root(), "0-0040", 0).find("no PWM chip '0-0040'"), std::string::npos);
  EXPECT_NE(refusal(tree.root(), "0-0040", 0).find("fe20c000.pwm"), std::string::npos);
  EXPECT_NE(refusal(tree.root() + "/nothing", "0-0040", 0).find("there is none"), std::string::npos);
  EXPECT_NE(refusal(tree.root(), "fe20d000.pwm", 1).find("no channel 1"), std::string::npos);
  EXPECT_EQ(refusal(tree.root(), "fe20c000.pwm", 1), "");
}

TEST(SysfsPanTilt, StandsAtItsNeutralPositionFromTheStartOn) {
  const PwmTree tree;
  const SysfsPanTilt unit(options_for(tree), axes(), {9 * kDeg, 0});
  EXPECT_EQ(tree.value("pwmchip3/pwm0/period"), "20000000");
  EXPECT_EQ(tree.value("pwmchip3/pwm0/duty_cycle"), "1600000");
  EXPECT_EQ(tree.value("pwmchip3/pwm1/duty_cycle"), "1500000");
  EXPECT_EQ(tree.value("pwmchip3/pwm0/enable"), "1");
  EXPECT_NEAR(unit.state().angles.pan_rad, 9 * kDeg, 1e-9);
}

TEST(SysfsPanTilt, WritesThePulsesAndCutsThemAtTheirLimits) {
  const PwmTree tree;
  SysfsPanTilt unit(options_for(tree), axes(), {});
  unit.move_to({-22.5 * kDeg, 40 * kDeg});
  EXPECT_EQ(tree.value("pwmchip3/pwm0/duty_cycle"), "1250000");
  EXPECT_EQ(tree.value("pwmchip3/pwm1/duty_cycle"), "1900000");
  EXPECT_TRUE(unit.state().limited);
  EXPECT_FALSE(unit.state().failed);
  EXPECT_NEAR(unit.state().angles.tilt_rad, 36 * kDeg, 1e-9) << "where the cut pulse turns it";
  unit.move_to({});
  EXPECT_FALSE(unit.state().limited);
}

TEST(SysfsPanTilt, ComesIntoUseWhenItsChipAppears) {
  const PwmTree tree;
  tree.pull_chip("pwmchip3");
  LatePanTiltOptions late;
  late.backoff = Backoff(2ms, 10ms);
  LatePanTilt head([&](const HeadAngles& at) { return std::make_unique<SysfsPanTilt>(options_for(tree), axes(), at); },
                   late);
  EXPECT_TRUE(head.state().failed);
  EXPECT_NE(head.problem().find("no PWM chip 'fe20c000.pwm'"), std::string::npos);
  tree.add_chip("pwmchip3", "fe20c000.pwm", 2);
  const MonoTime until = mono_now() + 10s;
  while (head.state().failed && mono_now() < until) std::this_thread::sleep_for(1ms);
  head.move_to({-22.5 * kDeg, 0});
  EXPECT_EQ(tree.value("pwmchip3/pwm0/duty_cycle"), "1250000");
  EXPECT_EQ(head.problem(), "");
}

TEST(SysfsPanTilt, RefusesAChannelThatItsChipWillNeverHave) {
  const PwmTree tree;
  SysfsPanTiltOptions options = options_for(tree);
  options.tilt_channel = 2;
  try {
    const LatePanTilt head([&](const HeadAngles& at) { return std::make_unique<SysfsPanTilt>(options, axes(), at); },
                           {});
    FAIL() << "waits for a channel that will never come";
  } catch (const StartupError& error) {
    EXPECT_NE(std::string(error.what()).find("no channel 2"), std::string::npos);
  }
}

/// A crash leaves the channels running and the servos under power.
TEST(SysfsPanTilt, GoesOnFromThePulsesThatACrashLeft) {
  const PwmTree tree;
  std::ofstream(tree.root() + "/pwmchip3/pwm0/duty_cycle") << "1750000\n";
  std::ofstream(tree.root() + "/pwmchip3/pwm0/enable") << "1\n";
  std::ofstream(tree.root() + "/pwmchip3/pwm1/duty_cycle") << "1950000\n";
  std::ofstream(tree.root() + "/pwmchip3/pwm1/enable") << "1\n";
  const SysfsPanTilt unit(options_for(tree), axes(), {9 * kDeg, 9 * kDeg});
  EXPECT_EQ(tree.value("pwmchip3/pwm0/duty_cycle"), "1750000");
  EXPECT_NEAR(unit.state().angles.pan_rad, 22.5 * kDeg, 1e-9);
  EXPECT_EQ(tree.value("pwmchip3/pwm1/duty_cycle"), "1600000") << "a pulse beyond its limits was none of ours";
  EXPECT_NEAR(unit.state().angles.tilt_rad, 9 * kDeg, 1e-9);
}

TEST(SysfsPanTilt, AChannelThatIsOffBeginsWhereTheHeadIsTakenToBe) {
  const PwmTree tree;
  std::ofstream(tree.root() + "/pwmchip3/pwm0/duty_cycle") << "1750000\n";
  const SysfsPanTilt unit(options_for(tree), axes(), {9 * kDeg, 0});
  EXPECT_EQ(tree.value("pwmchip3/pwm0/duty_cycle"), "1600000");
}

TEST(SysfsPanTilt, StopsThePulsesAtTheEnd) {
  const PwmTree tree;
  { const SysfsPanTilt unit(options_for(tree), axes(), {}); }
  EXPECT_EQ(tree.value("pwmchip3/pwm0/enable"), "0");
  EXPECT_EQ(tree.value("pwmchip3/unexport"), "0");
}

TEST(SysfsPwm, WritesNothingWhereNothingChanges) {
  const PwmTree tree;
  SysfsPwm channel(tree.root(), "fe20c000.pwm", 1, 20ms, 1500us);
  std::ofstream(tree.root() + "/pwmchip3/pwm1/duty_cycle") << "untouched\n";
  ASSERT_TRUE(channel.set_pulse(1500us));
  EXPECT_EQ(tree.value("pwmchip3/pwm1/duty_cycle"), "untouched") << "a chip behind I2C waits for its bus at each write";
  ASSERT_TRUE(channel.set_pulse(1600us));
  EXPECT_EQ(tree.value("pwmchip3/pwm1/duty_cycle").substr(0, 7), "1600000");
}

}  // namespace
}  // namespace ninedot
