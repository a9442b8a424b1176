// Lines on made-up chips; the kernel's own are met in tests/hil.
#include "drivers/gpio/gpio_lines.h"

#include <gtest/gtest.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <thread>
#include <vector>

#include "base/mono_time.h"
#include "base/startup_error.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

std::vector<GpioChip> chips() {
  return {{"/dev/gpiochip0", "pinctrl-bcm2711", {{"ID_SDA", ""}, {"servo-power", ""}, {"", "spi0 CS0"}, {"", ""}}, 0},
          {"/dev/gpiochip1", "raspberrypi-exp-gpio", {{"WL_ON", "the kernel"}}, 0}};
}

std::string refusal(const std::string& line, const std::vector<GpioChip>& all) {
  try {
    find_gpio_line({line}, all);
  } catch (const StartupError& error) {
    EXPECT_EQ(error.status, ExitStatus::kWrongUsage);
    return error.what();
  }
  return "";
}

TEST(GpioLines, AreFoundByTheirNameAndByLabelAndOffset) {
  const GpioRequest by_name = find_gpio_line({"servo-power", true}, chips());
  EXPECT_EQ(by_name.chip_path, "/dev/gpiochip0");
  EXPECT_EQ(by_name.offset, 1U);
  EXPECT_TRUE(by_name.active_low);
  EXPECT_EQ(find_gpio_line({"pinctrl-bcm2711:3"}, chips()).offset, 3U);
}

TEST(GpioLines, AreRefusedWithTheNameOfWhoeverUsesThem) {
  EXPECT_NE(refusal("pinctrl-bcm2711:2", chips()).find("in use by 'spi0 CS0'"), std::string::npos);
  EXPECT_NE(refusal("WL_ON", chips()).find("in use by 'the kernel'"), std::string::npos);
}

TEST(GpioLines, AreRefusedWithTheChipsThatAreThereWhenThereIsNoSuchLine) {
  for (const char* line : {"servo", "pinctrl-bcm2711:4", "pinctrl-bcm2711:x", "other:0", ":1", ""}) {
    EXPECT_NE(refusal(line, chips()).find("pinctrl-bcm2711 (4 lines), raspberrypi-exp-gpio (1 lines)"),
              std::string::npos)
        << line << ": " << refusal(line, chips());
  }
  EXPECT_NE(refusal("servo", {}).find("no GPIO chip"), std::string::npos);
}

TEST(GpioLines, OfAChipThatMayNotBeOpenedLeadToTheAdviceForIt) {
  EXPECT_NE(refusal("servo", {{"/dev/null", "", {}, EACCES}}).find("permission missing"), std::string::npos);
}

/// A line whose level the test sets.
struct Wire {
  std::atomic<int> level{0};
  int fd = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
  ~Wire() { ::close(fd); }
  void set(int value) {
    level = value;
    const std::uint64_t one = 1;
    ASSERT_EQ(::write(fd, &one, sizeof one), 8);
  }
};

class WireHandle final : public GpioHandle {
 public:
  explicit WireHandle(Wire& wire) : wire_(wire) {}
  int set(bool) noexcept override { return 0; }
  int get() noexcept override { return wire_.level; }
  int event_fd() const noexcept override { return wire_.fd; }
  void drop_events() noexcept override {
    std::uint64_t count = 0;
    static_cast<void>(!::read(wire_.fd, &count, sizeof count));
  }

 private:
  Wire& wire_;
};

bool becomes(const DigitalInput& input, bool active) {
  const MonoTime until = mono_now() + 10s;
  while (input.is_active() != active && mono_now() < until) std::this_thread::sleep_for(1ms);
  return input.is_active() == active;
}

TEST(GpioInput, KnowsTheLevelAtTheStartAndFollowsEveryEdge) {
  Wire wire;
  wire.level = 1;
  const auto input = watch_gpio_input(std::make_unique<WireHandle>(wire));
  EXPECT_TRUE(input->is_active());
  for (int i = 0; i < 20; ++i) {
    wire.set(i % 2);
    EXPECT_TRUE(becomes(*input, i % 2 == 1));
  }
}

TEST(GpioInput, InhibitsWhenItCanNotBeRead) {
  Wire wire;
  const auto input = watch_gpio_input(std::make_unique<WireHandle>(wire));
  EXPECT_FALSE(input->is_active());
  wire.set(-ENODEV);
  EXPECT_TRUE(becomes(*input, true));
}

}  // namespace
}  // namespace ninedot
