#include "drivers/servo/bus_pan_tilt.h"

#include <gtest/gtest.h>

#include <cmath>
#include <mutex>
#include <numbers>
#include <vector>

#include "drivers/servo/pca9685.h"
#include "tests/servo/pca9685_emulated_chip.h"
#include "tests/support/allocation_counter.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

constexpr double kRad = std::numbers::pi / 180;

/// Pulses of 1500 us, and 10 more for each degree.
ServoAxes axes() {
  const std::array<AxisPoint, 2> points{{{-90 * kRad, 600}, {90 * kRad, 2400}}};
  const ServoAxis axis(points, 1000, 2000);
  return {axis, axis};
}
HeadAngles angles_deg(double pan_deg, double tilt_deg) { return {pan_deg * kRad, tilt_deg * kRad}; }

/// Servos in memory. What they were told stays when the bus is opened anew.
struct Servos {
  std::mutex mutex;
  std::vector<std::string> told;
  std::optional<ServoTargets> position;
  ServoHealth health;
  std::atomic<bool> broken{false}, absent{false}, fails_release{false}, blind{false};
  std::atomic<int> opened{0}, open_now{0}, releases{0};
  std::atomic<std::chrono::milliseconds> takes{0ms};

  class Bus final : public ServoBus {
   public:
    explicit Bus(Servos& servos) : servos_(servos) { ++servos_.open_now; }
    ~Bus() override { --servos_.open_now; }
    Result<void> drive(const ServoTargets& targets) noexcept override {
      std::this_thread::sleep_for(servos_.takes.load());
      return say("drive " + std::to_string(std::lround(targets.pan)) + " " + std::to_string(std::lround(targets.tilt)));
    }
    Result<void> release() noexcept override {
      ++servos_.releases;
      if (servos_.fails_release) return fail(Errc::kIo, "made up", EIO);
      return say("release");
    }
    Result<ServoReading> look() noexcept override {
      if (servos_.broken || servos_.blind) return fail(Errc::kIo, "made up", EIO);
      const std::lock_guard lock(servos_.mutex);
      return ServoReading{servos_.position, servos_.health};
    }

   private:
    Result<void> say(const std::string& what) {
      if (servos_.broken) return fail(Errc::kIo, "made up", EIO);
      const std::lock_guard lock(servos_.mutex);
      servos_.told.push_back(what);
      return {};
    }
    Servos& servos_;
  };
  std::unique_ptr<ServoBus> open() {
    if (absent) throw DeviceAbsent("made up: absent");
    ++opened;
    return std::make_unique<Bus>(*this);
  }
  std::vector<std::string> all() {
    const std::lock_guard lock(mutex);
    return told;
  }
  std::string last() {
    const std::lock_guard lock(mutex);
    return told.empty() ? "nothing" : told.back();
  }
};

BusPanTiltOptions impatient(WhenStopped when_stopped = WhenStopped::kRelease) {
  BusPanTiltOptions options;
  options.when_stopped = when_stopped;
  options.look_interval = 5ms;
  options.reopening = Backoff(5ms, 20ms);
  return options;
}

bool eventually(const std::function<bool()>& condition) {
  const auto until = std::chrono::steady_clock::now() + 20s;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > until) return false;
    std::this_thread::sleep_for(1ms);
  }
  return true;
}

std::unique_ptr<BusPanTilt> head_on(Servos& servos, const BusPanTiltOptions& options = impatient()) {
  return std::make_unique<BusPanTilt>([&servos] { return servos.open(); }, options, axes(), angles_deg(5, -5));
}

TEST(BusPanTilt, StandsAtNeutralAndGoesWhereItIsSent) {
  Servos servos;
  const auto head = head_on(servos);
  EXPECT_EQ(servos.all(), std::vector<std::string>{"drive 1550 1450"});
  EXPECT_NEAR(head->state().angles.pan_rad, 5 * kRad, 1e-9);
  head->move_to(angles_deg(10, 20));
  EXPECT_TRUE(eventually([&] { return servos.last() == "drive 1600 1700"; }));
  EXPECT_TRUE(eventually([&] { return std::abs(head->state().angles.tilt_rad - 20 * kRad) < 1e-9; }));
  EXPECT_FALSE(head->state().failed);
  EXPECT_FALSE(head->state().limited);
  head->move_to(angles_deg(80, 20));
  EXPECT_TRUE(head->state().limited);
  EXPECT_TRUE(eventually([&] { return servos.last() == "drive 2000 1700"; }));
}

TEST(BusPanTilt, SaysWhereTheServosAreRatherThanWhereTheyWereSent) {
  Servos servos;
  servos.position = ServoTargets{1400, 1700};
  const auto head = head_on(servos);
  EXPECT_NEAR(head->state().angles.pan_rad, -10 * kRad, 1e-9);
  EXPECT_NEAR(head->state().angles.tilt_rad, 20 * kRad, 1e-9);
}

TEST(BusPanTilt, TheNewestTargetWinsOnASlowBus) {
  Servos servos;
  const auto head = head_on(servos);
  servos.takes = 50ms;
  for (int i = 1; i <= 40; ++i) head->move_to(angles_deg(i, 0));
  EXPECT_TRUE(eventually([&] { return servos.last() == "drive 1900 1500"; }));
  EXPECT_LE(servos.all().size(), 5U);
}

TEST(BusPanTilt, StopReleasesOnceAndTheNextTargetDrivesAgain) {
  Servos servos;
  const auto head = head_on(servos);
  head->stop();
  EXPECT_TRUE(eventually([&] { return servos.last() == "release"; }));
  head->move_to(angles_deg(5, -5));
  EXPECT_TRUE(eventually([&] { return servos.last() == "drive 1550 1450"; })) << "the same target as before the stop";
}

TEST(BusPanTilt, StopHoldsWhereTheServosAreWhenItShall) {
  Servos servos;
  servos.position = ServoTargets{1510, 1490};
  {
    const auto head = head_on(servos, impatient(WhenStopped::kHold));
    head->move_to(angles_deg(40, 0));
    EXPECT_TRUE(eventually([&] { return servos.last() == "drive 1900 1500"; }));
    head->stop();
    EXPECT_TRUE(eventually([&] { return servos.last() == "drive 1510 1490"; }));
  }
  EXPECT_EQ(servos.releases, 0);
}

TEST(BusPanTilt, TheEndReleasesAndTriesThreeTimes) {
  Servos servos;
  { const auto head = head_on(servos); }
  EXPECT_EQ(servos.last(), "release");
  EXPECT_EQ(servos.releases, 1);
  EXPECT_EQ(servos.open_now, 0);
  servos.fails_release = true;
  { const auto head = head_on(servos); }
  EXPECT_EQ(servos.releases, 4);
}

TEST(BusPanTilt, TheEndReleasesServosWhoseBusWasLostAndIsBack) {
  Servos servos;
  BusPanTiltOptions slow = impatient();
  slow.reopening = Backoff(60s, 60s);
  {
    const auto head = head_on(servos, slow);
    servos.broken = true;
    EXPECT_TRUE(eventually([&] { return servos.open_now == 0; }));
    servos.broken = false;
  }
  EXPECT_EQ(servos.last(), "release");
}

TEST(BusPanTilt, WhatCannotBeMadeIsReleased) {
  Servos servos;
  servos.blind = true;
  EXPECT_THROW(head_on(servos), DeviceAbsent);
  EXPECT_EQ(servos.all(), (std::vector<std::string>{"release"}));
}

TEST(BusPanTilt, OpensALostBusAnewAndSaysTheNewestOrderAgain) {
  Servos servos;
  const auto head = head_on(servos);
  servos.health.supply_V = 12;
  EXPECT_TRUE(eventually([&] { return head->state().servos.supply_V == 12; }));
  servos.absent = true;
  servos.broken = true;
  EXPECT_TRUE(eventually([&] { return head->state().failed; }));
  EXPECT_TRUE(eventually([&] { return std::isnan(head->state().servos.supply_V); }));
  EXPECT_TRUE(eventually([&] { return servos.open_now == 0; })) << "closed: somebody may need it to come back";
  EXPECT_EQ(head->state().losses, 1U);
  head->move_to(angles_deg(-20, 0));
  servos.broken = false;
  servos.absent = false;
  EXPECT_TRUE(eventually([&] { return servos.last() == "drive 1300 1500"; }));
  EXPECT_TRUE(eventually([&] { return !head->state().failed; }));
  EXPECT_EQ(servos.opened, 2);
}

TEST(BusPanTilt, AStopThatNobodyHeardIsSaidAgainToABusThatComesBack) {
  Servos servos;
  const auto head = head_on(servos);
  servos.broken = true;
  EXPECT_TRUE(eventually([&] { return head->state().failed; }));
  head->stop();
  servos.broken = false;
  EXPECT_TRUE(eventually([&] { return servos.last() == "release"; }));
  EXPECT_EQ(servos.all(), (std::vector<std::string>{"drive 1550 1450", "release"})) << "it never moved in between";
}

TEST(BusPanTilt, NeitherWaitsNorAllocatesForTheCaller) {
  Servos servos;
  const auto head = head_on(servos);
  servos.takes = 300ms;
  head->move_to(angles_deg(1, 0));
  std::this_thread::sleep_for(20ms);
  const auto before = std::chrono::steady_clock::now();
  {
    const test::AllocationGuard guard;
    for (int i = 0; i < 100; ++i) {
      head->move_to(angles_deg(i * 0.1, 0));
      if (i % 10 == 0) head->stop();
      static_cast<void>(head->state());
    }
    EXPECT_EQ(guard.allocations(), 0U);
  }
  EXPECT_LT(std::chrono::steady_clock::now() - before, 100ms) << "while the bus is busy for 300 ms";
}

TEST(BusPanTilt, WhatIsNotThereIsRefusedWhatItSays) {
  Servos servos;
  servos.absent = true;
  EXPECT_THROW(head_on(servos), DeviceAbsent);
  servos.absent = false;
  servos.broken = true;
  try {
    head_on(servos);
    FAIL() << "made";
  } catch (const DeviceAbsent& absent) {
    EXPECT_EQ(std::string(absent.what()), "made up: Input/output error");
  }
}

TEST(BusPanTilt, APca9685ThatLostItsSupplyIsSetUpAgainAndGetsItsPulsesBack) {
  test::EmulatedPca9685 chip;
  BusPanTilt head([&chip] { return std::make_unique<Pca9685>(chip.handle(), Pca9685Options{}, nullptr); }, impatient(),
                  axes(), angles_deg(0, 0));
  EXPECT_EQ(chip.pulse(0), 307);
  chip.power_cycle();
  EXPECT_TRUE(eventually([&] { return chip.pulse(0) == 307 && chip.pulse(1) == 307; }));
  EXPECT_TRUE(eventually([&] { return !head.state().failed; }));
  EXPECT_GE(head.state().losses, 1U);
  EXPECT_EQ(chip.open_handles, 1);
}

/// A head on the chip; nobody asked it anything yet.
std::unique_ptr<BusPanTilt> head_on(test::EmulatedPca9685& chip, const HeadAngles& at,
                                    const BusPanTiltOptions& options = impatient()) {
  return std::make_unique<BusPanTilt>(
      [&chip] { return std::make_unique<Pca9685>(chip.handle(), Pca9685Options{}, nullptr); }, options, axes(), at);
}

/// Whether an output was switched off, or the chip sent to sleep.
bool has_paused(const test::EmulatedPca9685& chip) {
  return std::ranges::any_of(chip.writes(), [](const auto& write) {
    return (write.address == 0x00 && (write.values.front() & 0x10) != 0) ||
           (write.values.size() == 4 && (write.values.back() & 0x10) != 0);
  });
}

TEST(BusPanTilt, APca9685ThatAKillLeftRunningIsWhereItsPulsesSayAndGoesOnFromThere) {
  test::EmulatedPca9685 chip;
  head_on(chip, angles_deg(-30, 20), impatient(WhenStopped::kHold)).reset();
  EXPECT_EQ(chip.pulse(0), 246);
  chip.forget_writes();
  const auto head = head_on(chip, angles_deg(5, -5));
  EXPECT_NEAR(head->state().angles.pan_rad, -29.952 * kRad, 1e-9) << "1200.48 us, not 1550";
  EXPECT_NEAR(head->state().angles.tilt_rad, 19.824 * kRad, 1e-9) << "1698.24 us";
  EXPECT_FALSE(head->state().limited);
  head->move_to(angles_deg(-29, 20));
  EXPECT_TRUE(eventually([&] { return chip.pulse(0) == 248; }));
  EXPECT_FALSE(has_paused(chip));
}

TEST(BusPanTilt, APca9685WithOnePulseLeftGetsTheOtherForWhereTheHeadIsTakenToBe) {
  test::EmulatedPca9685 chip;
  head_on(chip, angles_deg(-30, 20), impatient(WhenStopped::kHold)).reset();
  chip.set(0x09, 0x10);
  const auto head = head_on(chip, angles_deg(5, -5));
  EXPECT_EQ(chip.pulse(0), 318) << "1550 us";
  EXPECT_NEAR(head->state().angles.pan_rad, 5 * kRad, 1e-9);
  EXPECT_EQ(chip.pulse(1), 348);
  EXPECT_NEAR(head->state().angles.tilt_rad, 19.824 * kRad, 1e-9);
}

TEST(BusPanTilt, APca9685ThatWasSilentForAMomentKeepsItsPulses) {
  test::EmulatedPca9685 chip;
  const auto head = head_on(chip, angles_deg(0, 0));
  chip.forget_writes();
  chip.fails_from = 0;
  EXPECT_TRUE(eventually([&] { return head->state().failed; }));
  chip.fails_from = -1;
  EXPECT_TRUE(eventually([&] { return !head->state().failed; }));
  EXPECT_EQ(chip.pulse(0), 307);
  EXPECT_EQ(chip.pulse(1), 307);
  EXPECT_FALSE(has_paused(chip));
}

TEST(BusPanTilt, APca9685IsOffAfterTheEnd) {
  test::EmulatedPca9685 chip;
  {
    const BusPanTilt head([&chip] { return std::make_unique<Pca9685>(chip.handle(), Pca9685Options{}, nullptr); },
                          impatient(), axes(), angles_deg(0, 0));
    EXPECT_NE(chip.pulse(1), 0);
  }
  EXPECT_EQ(chip.get(0x09), 0x10);
  EXPECT_EQ(chip.get(0x0D), 0x10);
}

}  // namespace
}  // namespace ninedot
