#include "drivers/servo/smart_servos.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "drivers/posix/late_device.h"
#include "drivers/servo/bus_pan_tilt.h"
#include "drivers/servo/dynamixel.h"
#include "drivers/servo/feetech.h"
#include "tests/servo/emulated_servos.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;
using test::EmulatedServos;
using test::ServoMaker;

constexpr double kRad = std::numbers::pi / 180;
constexpr int kPan = 7, kTilt = 12;

std::unique_ptr<const ServoDialect> dialect_of(ServoMaker maker) {
  if (maker == ServoMaker::kDynamixel) return std::make_unique<DynamixelDialect>();
  return std::make_unique<FeetechDialect>(maker == ServoMaker::kFeetechSts ? FeetechSeries::kSts : FeetechSeries::kScs);
}

bool eventually(const std::function<bool()>& condition) {
  const auto until = std::chrono::steady_clock::now() + 20s;
  while (!condition()) {
    if (std::chrono::steady_clock::now() > until) return false;
    std::this_thread::sleep_for(1ms);
  }
  return true;
}

/// The same laws for all makers.
class SmartServosOf : public testing::TestWithParam<ServoMaker> {
 protected:
  SmartServoOptions options() const {
    SmartServoOptions options;
    options.device = emulated.device();
    options.baud = 115200;
    options.pan_id = kPan;
    options.tilt_id = kTilt;
    options.reply_timeout = 150ms;  // the machine may be busy
    options.pan_steps_per_s = 300;
    options.tilt_steps_per_s = 600;
    return options;
  }
  SmartServos servos() const { return {options(), dialect_of(GetParam())}; }
  /// 600 of their positions are 60 deg, 500 are straight ahead.
  static ServoAxes axes() {
    const std::array<AxisPoint, 2> points{{{-50 * kRad, 0}, {50 * kRad, 1000}}};
    const ServoAxis axis(points, 0, 1000);
    return {axis, axis};
  }
  std::unique_ptr<BusPanTilt> head(WhenStopped when_stopped = WhenStopped::kRelease) const {
    BusPanTiltOptions patience;
    patience.when_stopped = when_stopped;
    patience.look_interval = 5ms;
    patience.reopening = Backoff(10ms, 50ms);
    return std::make_unique<BusPanTilt>(
        [this] { return std::make_unique<SmartServos>(options(), dialect_of(GetParam())); }, patience, axes(),
        HeadAngles{});
  }
  bool gets_to(const BusPanTilt& head, double pan_deg, double tilt_deg) const {
    return eventually([&] {
      const HeadState state = head.state();
      return !state.failed && std::abs(state.angles.pan_rad / kRad - pan_deg) < 0.06 &&
             std::abs(state.angles.tilt_rad / kRad - tilt_deg) < 0.06 &&
             std::abs(emulated.position(kPan) - (500 + 10 * pan_deg)) < 1 &&
             std::abs(emulated.position(kTilt) - (500 + 10 * tilt_deg)) < 1;
    });
  }
  std::string refusal() const {
    try {
      servos();
    } catch (const StartupError& error) {
      std::string line = error.what();
      const auto at = line.find(emulated.device());
      return at == std::string::npos ? line : line.replace(at, emulated.device().size(), "DEVICE");
    }
    return "taken";
  }

  EmulatedServos emulated{GetParam(), {kPan, kTilt}};
};

TEST_P(SmartServosOf, AreWithoutForceUntilTheyAreDriven) {
  SmartServos bus = servos();
  EXPECT_FALSE(emulated.has_force(kPan));
  EXPECT_FALSE(emulated.has_force(kTilt));
  ASSERT_TRUE(bus.drive({300, 700}));
  EXPECT_TRUE(emulated.has_force(kPan));
  EXPECT_TRUE(emulated.has_force(kTilt));
  EXPECT_TRUE(eventually([&] { return emulated.position(kPan) == 300 && emulated.position(kTilt) == 700; }));
  ASSERT_TRUE(bus.release());
  EXPECT_FALSE(emulated.has_force(kPan));
  EXPECT_FALSE(emulated.has_force(kTilt));
}

TEST_P(SmartServosOf, AreToldTheirSpeed) {
  SmartServos bus = servos();
  ASSERT_TRUE(bus.drive({300, 700}));
  // Dynamixel: 300 and 600 steps/s in units of 0.229 rev/min.
  const bool is_dynamixel = GetParam() == ServoMaker::kDynamixel;
  EXPECT_TRUE(eventually([&] { return emulated.speed(kPan) == (is_dynamixel ? 19 : 300); }));
  EXPECT_TRUE(eventually([&] { return emulated.speed(kTilt) == (is_dynamixel ? 38 : 600); }));
}

TEST_P(SmartServosOf, TellWhereTheyAreAndTheWorseOfBothHealths) {
  SmartServos bus = servos();
  emulated.put_at(kPan, 123);
  emulated.put_at(kTilt, 456);
  emulated.set_load(kPan, 150);
  emulated.set_load(kTilt, GetParam() == ServoMaker::kDynamixel ? -320 : 0x400 + 320);
  emulated.set_supply(kPan, 118);
  emulated.set_temperature(kPan, 52);
  std::this_thread::sleep_for(20ms);
  const auto reading = bus.look();
  ASSERT_TRUE(reading);
  ASSERT_TRUE(reading->position);
  EXPECT_EQ(*reading->position, (ServoTargets{123, 456}));
  EXPECT_NEAR(reading->health.load_percent, 32, 1e-9);
  EXPECT_NEAR(reading->health.supply_V, 11.8, 1e-9);
  EXPECT_EQ(reading->health.temperature_degC, 52);
}

TEST_P(SmartServosOf, LetEchoesNoiseDoublesAndPiecesPass) {
  emulated.faults.echo = emulated.faults.noise = emulated.faults.twice = emulated.faults.in_pieces = true;
  const auto driven = head();
  for (const double pan : {10.0, -20.0, 30.0}) {
    driven->move_to({pan * kRad, -pan * kRad});
    EXPECT_TRUE(gets_to(*driven, pan, -pan));
  }
  EXPECT_EQ(driven->state().losses, 0U);
}

TEST_P(SmartServosOf, EachOfTheseAloneIsNoReasonForALoss) {
  for (std::atomic<bool>* fault : {&emulated.faults.echo, &emulated.faults.noise, &emulated.faults.twice,
                                   &emulated.faults.in_pieces, &emulated.faults.answers_no_writes}) {
    *fault = true;
    const auto driven = head();
    driven->move_to({12 * kRad, -12 * kRad});
    EXPECT_TRUE(gets_to(*driven, 12, -12));
    EXPECT_EQ(driven->state().losses, 0U);
    *fault = false;
  }
}

TEST_P(SmartServosOf, AnAnswerThatCameTwiceIsNotTakenForTheNextOne) {
  SmartServos bus = servos();
  emulated.faults.twice = true;
  for (const int position : {100, 200, 300, 400}) {
    emulated.put_at(kPan, position);
    emulated.put_at(kTilt, 2 * position);
    std::this_thread::sleep_for(20ms);
    const auto reading = bus.look();
    ASSERT_TRUE(reading);
    ASSERT_TRUE(reading->position);
    EXPECT_EQ(*reading->position, (ServoTargets{1.0 * position, 2.0 * position}));
  }
}

TEST_P(SmartServosOf, LateAnswersAreNoModeToRefuse) {
  emulated.faults.late_torques = 2 * SmartServos::kAttempts;
  EXPECT_EQ(refusal(), "taken");
}

TEST_P(SmartServosOf, WhatTheAdapterBringsBackIsNoAnswer) {
  // Else the next question would be on the line together with the answer to this one.
  emulated.faults.echo = emulated.faults.silent = true;
  const auto dialect = dialect_of(GetParam());
  auto serial = SerialLine::open(emulated.device(), 115200);
  ASSERT_TRUE(serial);
  HalfDuplexLine line(*std::move(serial), *dialect);
  const std::array<std::uint8_t, 1> on{1};
  ASSERT_TRUE(line.send(dialect->encode_write({kPan, on}, dialect->table().torque_address)));
  const auto heard = line.receive(mono_now() + 200ms);
  ASSERT_TRUE(heard);
  EXPECT_FALSE(*heard);
}

TEST_P(SmartServosOf, GetThereThoughEveryTenthAnswerIsLostAndAnotherSpoilt) {
  const auto driven = head();
  emulated.faults.lost_percent = 10;
  emulated.faults.spoilt_percent = 10;
  for (int i = 1; i <= 10; ++i) {
    driven->move_to({3 * i * kRad, -2 * i * kRad});
    EXPECT_TRUE(gets_to(*driven, 3 * i, -2 * i)) << i;
  }
}

TEST_P(SmartServosOf, StayWhereTheyStandUntilTheHeadIsTold) {
  emulated.put_at(kPan, 620);
  emulated.put_at(kTilt, 480);
  const auto driven = head();
  EXPECT_TRUE(eventually([&] { return std::abs(driven->state().angles.pan_rad - 12 * kRad) < 0.001; }));
  EXPECT_TRUE(driven->state().measured);
  EXPECT_FALSE(emulated.has_force(kPan) || emulated.has_force(kTilt));
  EXPECT_NEAR(emulated.position(kPan), 620, 0.5);
  driven->move_to({});
  EXPECT_TRUE(gets_to(*driven, 0, 0));
}

TEST_P(SmartServosOf, AGoalThatNobodyHeardIsSaidAgain) {
  const auto driven = head();
  driven->move_to({});
  EXPECT_TRUE(gets_to(*driven, 0, 0));
  emulated.faults.lost_goals = 2;
  driven->move_to({25 * kRad, 5 * kRad});
  EXPECT_TRUE(gets_to(*driven, 25, 5)) << "the caller does not say it again";
  EXPECT_EQ(emulated.faults.lost_goals, 0);
  EXPECT_EQ(driven->state().losses, 0U) << "and the line was not opened anew for it";
}

TEST_P(SmartServosOf, SilenceIsALossAndTheyComeBackToTheNewestTarget) {
  const auto driven = head();
  emulated.faults.silent = true;
  EXPECT_TRUE(eventually([&] { return driven->state().failed; }));
  EXPECT_TRUE(std::isnan(driven->state().servos.supply_V));
  driven->move_to({-15 * kRad, 15 * kRad});
  emulated.faults.silent = false;
  EXPECT_TRUE(gets_to(*driven, -15, 15));
  EXPECT_GE(driven->state().losses, 1U);
  EXPECT_NEAR(driven->state().servos.supply_V, 12, 1e-6);
}

TEST_P(SmartServosOf, AnAdapterThatWasPulledIsOpenedAgain) {
  const auto driven = head();
  emulated.unplug();
  EXPECT_TRUE(eventually([&] { return driven->state().failed; }));
  driven->move_to({20 * kRad, 0});
  emulated.plug();
  EXPECT_TRUE(gets_to(*driven, 20, 0));
}

TEST_P(SmartServosOf, AMomentWithoutSupplyIsNoticedAndForceComesBack) {
  const auto driven = head();
  driven->move_to({20 * kRad, 0});
  EXPECT_TRUE(gets_to(*driven, 20, 0));
  emulated.power_cycle();
  EXPECT_TRUE(eventually([&] { return emulated.has_force(kPan) && emulated.has_force(kTilt); }));
  EXPECT_TRUE(gets_to(*driven, 20, 0));
}

TEST_P(SmartServosOf, AnAlarmIsAFaultUntilItIsOver) {
  const auto driven = head();
  emulated.set_alarm(kTilt, true);
  EXPECT_TRUE(eventually([&] { return driven->state().failed; }));
  emulated.set_alarm(kTilt, false);
  EXPECT_TRUE(eventually([&] { return !driven->state().failed; }));
}

TEST_P(SmartServosOf, AreWithoutForceAfterAStopAndAfterTheEnd) {
  {
    const auto driven = head();
    driven->move_to({});
    EXPECT_TRUE(eventually([&] { return emulated.has_force(kPan) && emulated.has_force(kTilt); }));
    driven->stop();
    EXPECT_TRUE(eventually([&] { return !emulated.has_force(kPan) && !emulated.has_force(kTilt); }));
    emulated.put_at(kPan, 800);
    EXPECT_TRUE(eventually([&] { return std::abs(driven->state().angles.pan_rad - 30 * kRad) < 0.001; }))
        << "a hand turns it, and it says where it is";
    driven->move_to({10 * kRad, 0});
    EXPECT_TRUE(gets_to(*driven, 10, 0));
  }
  EXPECT_FALSE(emulated.has_force(kPan));
  EXPECT_FALSE(emulated.has_force(kTilt));
}

TEST_P(SmartServosOf, OneThatIsLeftAloneLetsGoUnlessItShallHold) {
  for (const bool lets_go : {false, true}) {
    emulated.set_alarm(kTilt, false);
    SmartServoOptions alone = options();
    alone.lone_lets_go = lets_go;
    ASSERT_TRUE(servos().drive({500, 500}));
    EXPECT_TRUE(emulated.has_force(kPan));
    emulated.set_alarm(kTilt, true);
    EXPECT_THROW(SmartServos(alone, dialect_of(GetParam())), DeviceAbsent);
    EXPECT_EQ(emulated.has_force(kPan), !lets_go);
  }
}

TEST_P(SmartServosOf, HoldTheirPlaceWhenTheyShall) {
  {
    const auto driven = head(WhenStopped::kHold);
    driven->move_to({});
    EXPECT_TRUE(gets_to(*driven, 0, 0));
    driven->stop();
    std::this_thread::sleep_for(50ms);
    EXPECT_TRUE(emulated.has_force(kPan));
  }
  EXPECT_TRUE(emulated.has_force(kPan));
  EXPECT_TRUE(emulated.has_force(kTilt));
}

TEST_P(SmartServosOf, RefusalsSayWhatToDo) {
  emulated.faults.silent = true;
  EXPECT_EQ(refusal(),
            "DEVICE: servo 7 does not answer at 115200 baud; are its supply, its wires, its ID and its rate right?");
  emulated.faults.silent = false;
  emulated.set_alarm(kTilt, true);
  EXPECT_EQ(refusal(),
            "DEVICE: servo 12 reports an error: overheated, overloaded, or its supply is out of range; mend "
            "that, and switch it off and on");
  emulated.set_alarm(kTilt, false);
  if (GetParam() != ServoMaker::kFeetechScs) {
    emulated.set_byte(kPan, GetParam() == ServoMaker::kDynamixel ? 11 : 33, 1);
    const int mode = GetParam() == ServoMaker::kDynamixel ? 3 : 0;
    EXPECT_EQ(refusal(), "DEVICE: servo 7 is in operating mode 1; set mode " + std::to_string(mode) +
                             ", position control, with its maker's tool");
  }
  emulated.unplug();
  EXPECT_EQ(refusal(),
            "DEVICE: there is no such serial port; connect the adapter, or correct the device of [pan_tilt]");
}

INSTANTIATE_TEST_SUITE_P(Makers, SmartServosOf,
                         testing::Values(ServoMaker::kDynamixel, ServoMaker::kFeetechSts, ServoMaker::kFeetechScs),
                         [](const auto& tested) {
                           return tested.param == ServoMaker::kDynamixel    ? "Dynamixel"
                                  : tested.param == ServoMaker::kFeetechSts ? "FeetechSts"
                                                                            : "FeetechScs";
                         });

TEST(SmartServos, APortThatIsNoneIsWrongUsage) {
  try {
    check_servo_port("/dev/null", 57600);
    FAIL() << "taken";
  } catch (const DeviceAbsent&) {
    FAIL() << "waiting does not mend it";
  } catch (const StartupError& error) {
    EXPECT_EQ(std::string(error.what()), "/dev/null: this is no serial port; correct the device of [pan_tilt]");
  }
}

}  // namespace
}  // namespace ninedot
