// Lines on made-up chips; the kernel's own are met in tests/hil.
#include "drivers/gpio/gpio_lines.h"

#include <gtest/gtest.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <functional>
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

/// What a line waits for: it may come.
std::string refusal(const std::string& line, const std::vector<GpioChip>& all) {
  try {
    find_gpio_line({line}, all);
  } catch (const DeviceAbsent& error) {
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
  for (const char* line : {"servo", "pinctrl-bcm2711:x", "other:0", ":1"}) {
    EXPECT_NE(refusal(line, chips()).find("pinctrl-bcm2711 (4 lines), raspberrypi-exp-gpio (1 lines)"),
              std::string::npos)
        << line << ": " << refusal(line, chips());
  }
  EXPECT_NE(refusal("servo", {}).find("no GPIO chip"), std::string::npos);
}

TEST(GpioLines, BeyondTheEndOfAChipThatIsThereAreNotWaitedFor) {
  for (const char* line : {"pinctrl-bcm2711:4", "raspberrypi-exp-gpio:1", ""}) {
    try {
      find_gpio_line({line}, chips());
      FAIL() << line;
    } catch (const DeviceAbsent&) {
      FAIL() << line;
    } catch (const StartupError& error) {
      EXPECT_EQ(error.status, ExitStatus::kWrongUsage);
    }
  }
}

TEST(GpioLines, OfAChipThatMayNotBeOpenedLeadToTheAdviceForIt) {
  EXPECT_NE(refusal("servo", {{"/dev/null", "", {}, EACCES}}).find("permission missing"), std::string::npos);
}

/// A line whose level the test sets, on a chip that may be pulled and put back.
struct Wire {
  std::atomic<int> level{0};
  std::atomic<bool> is_there{true};
  std::atomic<int> openings{0};
  std::atomic<bool> has_descriptor{true};
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
  Result<void> set(bool active) noexcept override {
    if (!wire_.is_there) return fail(Errc::kIo, "gone", ENODEV);
    wire_.level = active ? 1 : 0;
    return {};
  }
  Result<bool> get() noexcept override {
    const int level = wire_.level;
    if (level < 0) return fail(Errc::kIo, "the wire is cut", -level);
    return level == 1;
  }
  int event_fd() const noexcept override { return wire_.has_descriptor ? wire_.fd : -1; }
  void drop_events() noexcept override {
    std::uint64_t count = 0;
    static_cast<void>(!::read(wire_.fd, &count, sizeof count));
  }

 private:
  Wire& wire_;
};

InhibitInput::Open opener(Wire& wire) {
  return [&wire]() -> std::unique_ptr<GpioHandle> {
    if (!wire.is_there) throw DeviceAbsent("no chip");
    ++wire.openings;
    return std::make_unique<WireHandle>(wire);
  };
}

bool eventually(const std::function<bool()>& condition) {
  const MonoTime until = mono_now() + 10s;
  while (!condition() && mono_now() < until) std::this_thread::sleep_for(1ms);
  return condition();
}

bool becomes(const DigitalInput& input, bool active) {
  return eventually([&] { return input.is_active() == active; });
}

/// Impatient, so that tests are short.
const Backoff kSoon(2ms, 10ms);

TEST(InhibitInput, KnowsTheLevelAtTheStartAndFollowsEveryEdge) {
  Wire wire;
  wire.level = 1;
  const InhibitInput input(opener(wire));
  EXPECT_TRUE(input.is_active());
  EXPECT_EQ(input.problem(), "");
  for (int i = 0; i < 20; ++i) {
    wire.set(i % 2);
    EXPECT_TRUE(becomes(input, i % 2 == 1));
  }
  EXPECT_EQ(wire.openings, 1);
}

TEST(InhibitInput, InhibitsWhenItCanNotBeReadAndIsOpenedAgain) {
  Wire wire;
  const InhibitInput input(opener(wire), kSoon);
  EXPECT_FALSE(input.is_active());
  wire.is_there = false;
  wire.set(-ENODEV);
  EXPECT_TRUE(becomes(input, true));
  EXPECT_TRUE(eventually([&] { return input.problem() == "no chip"; })) << input.problem();
  wire.level = 0;
  std::this_thread::sleep_for(30ms);
  EXPECT_TRUE(input.is_active()) << "nobody has read the line since";
  wire.is_there = true;
  EXPECT_TRUE(becomes(input, false));
  EXPECT_EQ(input.problem(), "");
  wire.set(1);
  EXPECT_TRUE(becomes(input, true));
}

TEST(InhibitInput, InhibitsUntilItsChipIsThere) {
  Wire wire;
  wire.is_there = false;
  const InhibitInput input(opener(wire), kSoon);
  EXPECT_TRUE(input.is_active());
  EXPECT_EQ(input.problem(), "no chip");
  std::this_thread::sleep_for(30ms);
  EXPECT_TRUE(input.is_active());
  wire.is_there = true;
  EXPECT_TRUE(becomes(input, false));
  EXPECT_EQ(input.problem(), "");
}

TEST(InhibitInput, InhibitsWhenItHasNoDescriptorToWatch) {
  Wire wire;
  wire.has_descriptor = false;
  const InhibitInput input(opener(wire), kSoon);
  std::this_thread::sleep_for(50ms);
  EXPECT_TRUE(input.is_active()) << "the next edge would not be heard";
}

TEST(InhibitInput, InhibitsWhenThePollFails) {
  Wire wire;
  const InhibitInput input(opener(wire), kSoon);
  // There and back, so that its thread has done all of what it will do below: a sanitizer that meets a class for the
  // first time needs descriptors to look whether its memory can be read.
  wire.set(1);
  EXPECT_TRUE(becomes(input, true));
  wire.set(0);
  EXPECT_TRUE(becomes(input, false));
  // More descriptors than the limit allows: poll() fails with EINVAL, whatever they are.
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_NOFILE, &before), 0);
  const rlimit none{0, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &none), 0);
  wire.set(0);  // an edge wakes the poll() that is under way; the next one fails
  const bool inhibits = becomes(input, true);
  int blinks = 0;
  for (int i = 0; i < 200; ++i) {
    blinks += !input.is_active();
    std::this_thread::sleep_for(100us);
  }
  ASSERT_EQ(::setrlimit(RLIMIT_NOFILE, &before), 0);
  EXPECT_TRUE(inhibits);
  EXPECT_EQ(blinks, 0) << "a line that opens and can't be watched is not believed for an instant";
  EXPECT_TRUE(becomes(input, false)) << "and comes back";
}

TEST(InhibitInput, RefusesWhatWaitingWouldNotMend) {
  const auto open = []() -> std::unique_ptr<GpioHandle> {
    throw StartupError(ExitStatus::kWrongUsage, "no such offset");
  };
  EXPECT_THROW(InhibitInput{open}, StartupError);
}

class WireOutput final : public DigitalOutput {
 public:
  explicit WireOutput(Wire& wire) : handle_(wire) {}
  Result<void> set(bool active) noexcept override { return handle_.set(active); }

 private:
  WireHandle handle_;
};

TEST(LateGpioOutput, IsDrivenOnceItsChipIsThereAndAgainWhenItIsBack) {
  Wire wire;
  wire.is_there = false;
  LateGpioOutput output(
      [&]() -> std::unique_ptr<DigitalOutput> {
        if (!wire.is_there) throw DeviceAbsent("no chip");
        ++wire.openings;
        return std::make_unique<WireOutput>(wire);
      },
      kSoon);
  EXPECT_EQ(output.set(true).error().os_errno, ENODEV);
  EXPECT_EQ(output.problem(), "no chip");
  for (int round = 1; round <= 2; ++round) {
    wire.level = 0;
    wire.is_there = true;
    EXPECT_TRUE(eventually([&] { return output.set(true).has_value(); }));
    EXPECT_EQ(wire.level, 1);
    EXPECT_EQ(output.problem(), "");
    EXPECT_EQ(wire.openings, round);
    wire.is_there = false;
    EXPECT_FALSE(output.set(false));
    EXPECT_NE(output.problem(), "");
  }
}

}  // namespace
}  // namespace ninedot
