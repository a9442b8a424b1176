#include "drivers/servo/pca9685.h"

#include <gtest/gtest.h>

#include "base/startup_error.h"
#include "drivers/posix/late_device.h"
#include "tests/servo/pca9685_emulated_chip.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;
using test::EmulatedPca9685;

/// The OE pin's line.
struct OutputEnable {
  bool active = false, fails = false;
  int changes = 0;
  class Line final : public DigitalOutput {
   public:
    explicit Line(OutputEnable& pin) : pin_(pin) {}
    ~Line() override { pin_.active = false; }  // as the driver of real lines
    Result<void> set(bool active) noexcept override {
      if (pin_.fails) return fail(Errc::kIo, "made up", EIO);
      pin_.changes += active != pin_.active ? 1 : 0;
      pin_.active = active;
      return {};
    }

   private:
    OutputEnable& pin_;
  };
  std::unique_ptr<DigitalOutput> line() { return std::make_unique<Line>(*this); }
};

Pca9685 made(EmulatedPca9685& chip, const Pca9685Options& options = {}) { return {chip.handle(), options, nullptr}; }

TEST(Pca9685, PrescaleIsThatOfTheDataSheet) {
  // 7.3.5, the example below equation (1): 200 Hz at 25 MHz is 1Eh; and the ends of the range that it names.
  EXPECT_EQ(pca9685::prescale_of(5ms, 25e6), 0x1E);
  EXPECT_EQ(pca9685::prescale_of(20ms, 25e6), 121);
  EXPECT_EQ(pca9685::prescale_of(40ms, 25e6), 243);
  EXPECT_EQ(pca9685::prescale_of(20ms, 26.5e6), 128);
  EXPECT_EQ(pca9685::prescale_of(20ms, 53e6), std::nullopt) << "258";
  EXPECT_EQ(pca9685::prescale_of(1us, 25e6), std::nullopt);
}

TEST(Pca9685, PulsesAreRightWithinHalfAStepForEveryOscillator) {
  for (const double oscillator_hz : {23e6, 25e6, 25.8e6, 27e6}) {
    const auto prescale = pca9685::prescale_of(20ms, oscillator_hz);
    ASSERT_TRUE(prescale);
    const double step_us = (*prescale + 1) / oscillator_hz * 1e6;
    for (double pulse_us = 500; pulse_us <= 2500; pulse_us += 7.3) {
      const double made_us = pca9685::steps_of(pulse_us, *prescale, oscillator_hz) * step_us;
      EXPECT_NEAR(made_us, pulse_us, step_us / 2 + 1e-9);
    }
  }
  EXPECT_EQ(pca9685::steps_of(0, 121, 25e6), 1);
  EXPECT_EQ(pca9685::steps_of(1e6, 121, 25e6), 4095);
}

TEST(Pca9685, SleepsForThePeriodWakesUpAndDrivesNothingUntilItIsTold) {
  EmulatedPca9685 chip;
  Pca9685 head = made(chip, {3, 15});
  EXPECT_EQ(chip.get(0x00), 0x20) << "awake, counting registers up, deaf to all-call addresses";
  EXPECT_EQ(chip.get(0x01), 0x04) << "totem pole, not inverted, changes at STOP";
  EXPECT_EQ(chip.get(0xFE), 121);
  for (int channel = 0; channel < 16; ++channel) EXPECT_EQ(chip.pulse(channel), 0) << channel;
  chip.forget_writes();
  ASSERT_TRUE(head.drive({1500, 1000}));
  EXPECT_EQ(chip.pulse(3), 307) << "1500 us of 4.88 us each";
  EXPECT_EQ(chip.pulse(15), 205);
  const std::vector<EmulatedPca9685::Write> expected{{0x06 + 4 * 3, {0, 0, 0x33, 0x01}},
                                                     {0x06 + 4 * 15, {0, 0, 0xCD, 0x00}}};
  EXPECT_EQ(chip.writes(), expected) << "one transfer for each pulse: no mixture of an old and a new width";
}

TEST(Pca9685, WritesNothingWhereNothingChanges) {
  EmulatedPca9685 chip;
  Pca9685 head = made(chip);
  ASSERT_TRUE(head.drive({1500, 1500}));
  chip.forget_writes();
  ASSERT_TRUE(head.drive({1500, 1500}));
  EXPECT_TRUE(chip.writes().empty());
  ASSERT_TRUE(head.drive({1500, 1600}));
  EXPECT_EQ(chip.writes().size(), 1U);
}

TEST(Pca9685, LeavesTheOtherChannelsOfARunningChipAlone) {
  EmulatedPca9685 chip;
  {
    Pca9685 other = made(chip, {8, 9});
    ASSERT_TRUE(other.drive({1234, 1765}));
  }
  const int before = chip.pulse(8);
  chip.forget_writes();
  Pca9685 head = made(chip, {0, 1});
  ASSERT_TRUE(head.drive({1500, 1500}));
  EXPECT_EQ(chip.pulse(8), before);
  for (const auto& write : chip.writes())
    EXPECT_EQ(write.values.at(0) & 0x10, 0) << "no need to sleep: the period is right";
}

TEST(Pca9685, RestartsTheOtherChannelsAfterAChangeOfThePeriod) {
  EmulatedPca9685 chip;
  {
    Pca9685 other = made(chip, {8, 9, 10ms});
    ASSERT_TRUE(other.drive({1234, 1765}));
  }
  const int before = chip.pulse(8);
  Pca9685 head = made(chip, {0, 1, 20ms});
  EXPECT_EQ(chip.get(0xFE), 121);
  EXPECT_EQ(chip.pulse(8), before);
  EXPECT_EQ(chip.get(0x00) & 0x80, 0) << "RESTART was answered";
}

/// The destructor alone ends no pulses.
void leave_running(EmulatedPca9685& chip, const ServoTargets& pulses_us) {
  Pca9685 killed = made(chip);
  ASSERT_TRUE(killed.drive(pulses_us));
}

TEST(Pca9685, GoesOnWithThePulsesThatAKilledProgramLeftRunning) {
  EmulatedPca9685 chip;
  leave_running(chip, {1200, 1800});
  chip.forget_writes();
  Pca9685 head = made(chip);
  const std::vector<EmulatedPca9685::Write> expected{{0x00, {0x20}}, {0x01, {0x04}}, {0x00, {0x20}}};
  EXPECT_EQ(chip.writes(), expected) << "what it holds already: neither sleep nor full off, and no output is touched";
  EXPECT_EQ(chip.pulse(0), 246);
  EXPECT_EQ(chip.pulse(1), 369);
  EXPECT_TRUE(head.look());
  const RunningTargets running = head.running();
  ASSERT_TRUE(running.pan && running.tilt);
  EXPECT_NEAR(*running.pan, 1200.48, 1e-6) << "246 of 122 / 25 MHz each";
  EXPECT_NEAR(*running.tilt, 1800.72, 1e-6);
  chip.forget_writes();
  ASSERT_TRUE(head.drive({*running.pan, *running.tilt}));
  EXPECT_TRUE(chip.writes().empty()) << "the head stands there";
}

TEST(Pca9685, StopsAChipThatDoesNotRunAsItWouldRunIt) {
  for (const auto& [address, value, what] : {std::tuple{0x00, 0x30, "asleep"},
                                             {0x00, 0xA0, "awake, and not restarted"},
                                             {0xFE, 120, "another period"},
                                             {0x01, 0x14, "inverted"}}) {
    EmulatedPca9685 chip;
    leave_running(chip, {1200, 1800});
    chip.set(address, value);
    const Pca9685 head = made(chip);
    EXPECT_EQ(chip.get(0x09), 0x10) << what;
    EXPECT_EQ(chip.get(0x0D), 0x10) << what;
    EXPECT_FALSE(head.running().pan || head.running().tilt) << what;
    EXPECT_EQ(chip.get(0x00), 0x20) << what;
    EXPECT_EQ(chip.get(0x01), 0x04) << what;
    EXPECT_EQ(chip.get(0xFE), 121) << what;
  }
}

TEST(Pca9685, StopsAPulseThatWasNoneOfOursAndKeepsTheOther) {
  for (const auto& [address, value, what] : {std::tuple{0x06, 1, "begins later"},
                                             {0x07, 0x10, "full on"},
                                             {0x09, 0x10, "full off"},
                                             {0x09, 0x02, "longer than 2 ms"},
                                             {0x08, 0x64, "shorter than 1 ms"}}) {
    EmulatedPca9685 chip;
    leave_running(chip, {1200, 1800});
    chip.set(address, value);
    Pca9685 head = made(chip);
    EXPECT_EQ(chip.pulse(0), 0) << what;
    EXPECT_EQ(chip.get(0x09), 0x10) << what;
    EXPECT_FALSE(head.running().pan) << what;
    EXPECT_EQ(chip.pulse(1), 369) << what;
    EXPECT_TRUE(head.running().tilt) << what;
    EXPECT_TRUE(head.look()) << what;
  }
}

TEST(Pca9685, AServoThatStoodAtALimitOfItsPulsesStandsThereStill) {
  Pca9685Options options;
  options.pan_range = {900, 2100};
  const auto runs = [&](int pan_steps, int tilt_steps) {
    EmulatedPca9685 chip;
    leave_running(chip, {1500, 1500});
    for (const auto& [first, steps] : {std::pair{0x08, pan_steps}, {0x0C, tilt_steps}}) {
      chip.set(first, steps & 0xFF);
      chip.set(first + 1, steps >> 8);
    }
    const RunningTargets running = made(chip, options).running();
    return std::pair{running.pan.has_value(), running.tilt.has_value()};
  };
  // 2000 us are 409.8 steps, so the longest pulse is rounded up; 1000 us are 204.9, 900 and 2100 us 184.4 and 430.3.
  EXPECT_EQ(runs(184, 205), (std::pair{true, true}));
  EXPECT_EQ(runs(430, 410), (std::pair{true, true}));
  EXPECT_EQ(runs(183, 204), (std::pair{false, false}));
  EXPECT_EQ(runs(431, 411), (std::pair{false, false}));
}

TEST(Pca9685, ATransferThatFailsAtTheStartEndsNoPulse) {
  int transfers = 0;
  for (bool works = false; !works; ++transfers) {
    EmulatedPca9685 chip;
    leave_running(chip, {1200, 1800});
    chip.fails_at = transfers;
    try {
      made(chip);
      works = true;
    } catch (const DeviceAbsent&) {
    }
    EXPECT_EQ(works, chip.fails_at == 0) << "none was left that could fail";
    EXPECT_EQ(chip.pulse(0), 246) << transfers;
    EXPECT_EQ(chip.pulse(1), 369) << transfers;
  }
  EXPECT_EQ(transfers - 1, 16) << "3 and 8 questions, 3 writes, 2 that look whether all is right";
}

TEST(Pca9685, ReleaseIsFullOffInBothOutputsAndTheNextDriveComesBack) {
  EmulatedPca9685 chip;
  Pca9685 head = made(chip);
  ASSERT_TRUE(head.drive({1500, 1500}));
  ASSERT_TRUE(head.release());
  EXPECT_EQ(chip.get(0x09), 0x10);
  EXPECT_EQ(chip.get(0x0D), 0x10);
  EXPECT_TRUE(head.look());
  ASSERT_TRUE(head.drive({1500, 1500}));
  EXPECT_EQ(chip.pulse(0), 307);
  EXPECT_EQ(chip.pulse(1), 307);
}

TEST(Pca9685, OutputEnableGoesOnLastAndOffFirst) {
  EmulatedPca9685 chip;
  OutputEnable pin;
  Pca9685 head(chip.handle(), {}, pin.line());
  EXPECT_FALSE(pin.active) << "no pulse yet";
  ASSERT_TRUE(head.drive({1500, 1500}));
  EXPECT_TRUE(pin.active);
  chip.fails_from = 0;  // the bus hangs
  EXPECT_FALSE(head.release());
  EXPECT_FALSE(pin.active) << "the line does without the bus";
}

TEST(Pca9685, OutputEnableGoesOnLastWithPulsesThatStillRun) {
  EmulatedPca9685 chip;
  leave_running(chip, {1500, 1500});
  chip.forget_writes();
  OutputEnable pin;
  Pca9685 head(chip.handle(), {}, pin.line());
  EXPECT_FALSE(pin.active) << "nobody has said yet that the head may move";
  ASSERT_TRUE(head.drive({1500, 1500}));
  EXPECT_TRUE(pin.active);
  EXPECT_EQ(pin.changes, 1);
  ASSERT_TRUE(head.release());
  EXPECT_FALSE(pin.active);
  EXPECT_EQ(chip.pulse(0), 0);
}

TEST(Pca9685, ReleaseTriesBothOutputsAndSaysWhatFailed) {
  EmulatedPca9685 chip;
  OutputEnable pin;
  Pca9685 head(chip.handle(), {}, pin.line());
  ASSERT_TRUE(head.drive({1500, 1500}));
  pin.fails = true;
  EXPECT_FALSE(head.release());
  EXPECT_EQ(chip.pulse(0), 0);
  EXPECT_EQ(chip.pulse(1), 0);
}

TEST(Pca9685, NoticesAChipThatHasLostItsSupplyForAMoment) {
  EmulatedPca9685 chip;
  Pca9685 head = made(chip);
  ASSERT_TRUE(head.drive({1500, 1500}));
  ASSERT_TRUE(head.look());
  chip.power_cycle();
  const auto looked = head.look();
  ASSERT_FALSE(looked);
  EXPECT_EQ(looked.error().os_errno, EIO);
}

TEST(Pca9685, TakesAChipWhoseExternalClockStaysOn) {
  EmulatedPca9685 chip;
  Pca9685 head = made(chip);
  ASSERT_TRUE(head.drive({1500, 1500}));
  chip.set(0x00, 0x60);
  EXPECT_TRUE(head.look());
}

TEST(Pca9685, NoticesEachRegisterThatSomebodyElseChanged) {
  for (const auto& [address, value] :
       {std::pair{0x00, 0x30}, {0xFE, 122}, {0x08, 1}, {0x09, 0x02}, {0x0C, 1}, {0x0D, 0x10}}) {
    EmulatedPca9685 chip;
    Pca9685 head = made(chip);
    ASSERT_TRUE(head.drive({1500, 1500}));
    ASSERT_TRUE(head.look());
    chip.set(address, value);
    EXPECT_FALSE(head.look()) << "register " << address;
  }
}

TEST(Pca9685, EveryTransferThatFailsIsToldAtOnce) {
  // The set-up: whichever transfer fails, there is no head.
  int transfers = 0;
  for (bool works = false; !works; ++transfers) {
    EmulatedPca9685 chip;
    chip.fails_from = transfers;
    try {
      made(chip);
      works = true;
    } catch (const DeviceAbsent& absent) {
      EXPECT_EQ(
          std::string(absent.what()),
          "no PCA9685 answers (made up: Remote I/O error); check its supply, its wires and the address of [pan_tilt]");
    }
  }
  EXPECT_GT(transfers, 8);
  for (int good = 0; good < 2; ++good) {
    EmulatedPca9685 chip;
    Pca9685 head = made(chip);
    chip.fails_from = good;
    EXPECT_FALSE(head.drive({1400, 1600})) << good;
    chip.fails_from = -1;
    EXPECT_TRUE(head.drive({1400, 1600})) << "what failed is tried again";
    EXPECT_EQ(chip.pulse(0), 287);
    EXPECT_EQ(chip.pulse(1), 328);
  }
  for (int good = 0; good < 6; ++good) {
    EmulatedPca9685 chip;
    Pca9685 head = made(chip);
    ASSERT_TRUE(head.drive({1400, 1600}));
    chip.fails_from = good;
    EXPECT_FALSE(head.look()) << good;
  }
}

TEST(Pca9685, RefusesAPeriodThatTheChipCannotHave) {
  EmulatedPca9685 chip;
  try {
    made(chip, {0, 1, 20ms, 60e6});
    FAIL() << "taken";
  } catch (const DeviceAbsent&) {
    FAIL() << "waiting does not mend it";
  } catch (const StartupError& error) {
    EXPECT_EQ(std::string(error.what()),
              "a PCA9685 at 6e+07 Hz has no period of 20 ms; correct period_ms of [pan_tilt]");
  }
}

TEST(I2cDevice, SaysWhatToDoAboutABusThatIsNoneOrNotThere) {
  try {
    open_i2c_device("/dev/i2c-there-is-none", 0x40);
    FAIL() << "opened";
  } catch (const DeviceAbsent& absent) {
    EXPECT_NE(std::string(absent.what()).find("there is no such I2C bus"), std::string::npos);
  }
  try {
    open_i2c_device("/dev/null", 0x40);
    FAIL() << "opened";
  } catch (const DeviceAbsent&) {
    FAIL() << "waiting does not mend it";
  } catch (const StartupError& error) {
    EXPECT_EQ(std::string(error.what()), "/dev/null: this is no I2C bus; correct the device of [pan_tilt]");
  }
}

}  // namespace
}  // namespace ninedot
