#include "drivers/servo/powered_head.h"

#include <gtest/gtest.h>

#include <cerrno>
#include <string>
#include <vector>

#include "drivers/posix/late_device.h"

namespace ninedot {
namespace {

using Events = std::vector<std::string>;

/// Tells what happened to it, in order.
class Servos final : public PanTilt {
 public:
  explicit Servos(Events& events) : events_(events) { events_.emplace_back("signals"); }
  ~Servos() override { events_.emplace_back("no signals"); }
  void move_to(const HeadAngles&) noexcept override { events_.emplace_back("move"); }
  void stop() noexcept override { events_.emplace_back("stop"); }
  HeadState state() const noexcept override {
    HeadState state;
    state.limited = true;
    return state;
  }

 private:
  Events& events_;
};

class Power final : public DigitalOutput {
 public:
  Power(Events& events, int error) : events_(events), error_(error) {}
  ~Power() override { events_.emplace_back("power off"); }
  Result<void> set(bool active) noexcept override {
    if (error_ != 0) return fail(Errc::kIo, "stuck", error_);
    events_.emplace_back(active ? "power on" : "power off");
    return {};
  }

 private:
  Events& events_;
  const int error_;
};

TEST(PoweredHead, GetsItsPowerLastAndLosesItFirst) {
  Events events;
  PoweredHeadOpener opener([&](const HeadAngles& /*at*/) { return std::make_unique<Servos>(events); },
                           [&] { return std::make_unique<Power>(events, 0); }, PowerComes::kLast);
  {
    const std::unique_ptr<PanTilt> head = opener.open({});
    head->move_to({});
    head->stop();
    EXPECT_TRUE(head->state().limited);
  }
  EXPECT_EQ(events, (Events{"signals", "power on", "move", "stop", "power off", "no signals"}));
}

TEST(PoweredHead, WaitsForItsPowerWithoutBeingOpenedAgain) {
  Events events;
  bool is_power_there = false;
  PoweredHeadOpener opener([&](const HeadAngles& /*at*/) { return std::make_unique<Servos>(events); },
                           [&]() -> std::unique_ptr<DigitalOutput> {
                             if (!is_power_there) throw DeviceAbsent("no chip");
                             return std::make_unique<Power>(events, 0);
                           },
                           PowerComes::kLast);
  EXPECT_THROW(opener.open({}), DeviceAbsent);
  EXPECT_THROW(opener.open({}), DeviceAbsent);
  is_power_there = true;
  const std::unique_ptr<PanTilt> head = opener.open({});
  EXPECT_EQ(events, (Events{"signals", "power on"}));
}

TEST(PoweredHead, IsAbsentWhileItsPowerCanNotBeSwitchedOn) {
  Events events;
  PoweredHeadOpener opener([&](const HeadAngles& /*at*/) { return std::make_unique<Servos>(events); },
                           [&] { return std::make_unique<Power>(events, ENODEV); }, PowerComes::kLast);
  EXPECT_THROW(opener.open({}), DeviceAbsent);
}

TEST(PoweredHead, ACameraKeepsItsPowerWhileItStartsUpAndLosesItLast) {
  Events events;
  bool is_up = false;
  PoweredHeadOpener opener(
      [&](const HeadAngles& /*at*/) -> std::unique_ptr<PanTilt> {
        events.emplace_back("asked");
        if (!is_up) throw DeviceAbsent("no answer");
        return std::make_unique<Servos>(events);
      },
      [&] { return std::make_unique<Power>(events, 0); }, PowerComes::kFirst);
  EXPECT_THROW(opener.open({}), DeviceAbsent);
  EXPECT_THROW(opener.open({}), DeviceAbsent);
  is_up = true;
  opener.open({}).reset();
  EXPECT_EQ(events, (Events{"power on", "asked", "asked", "asked", "signals", "no signals", "power off"}));
}

TEST(PoweredHead, NeedsNoPowerLine) {
  Events events;
  PoweredHeadOpener opener([&](const HeadAngles& /*at*/) { return std::make_unique<Servos>(events); }, nullptr,
                           PowerComes::kLast);
  EXPECT_NE(opener.open({}), nullptr);
}

}  // namespace
}  // namespace ninedot
