#include "drivers/modbus/request.h"

#include <gtest/gtest.h>

#include <random>
#include <string>

#include "tests/modbus/raw_client.h"
#include "tests/proto/known_report.h"

namespace ninedot {
namespace {

using test::be16;
using test::Bytes;
using test::operator+;
using test::read_pdu;
using test::registers_of;

class ModbusRequest : public testing::Test {
 protected:
  ModbusRequest() {
    now_ = mono_from_ns(5'000'000'000'000);
    reports_.publish(test::known_report(now_));
    options_.allow_writes = true;
    options_.supported_commands = 1U << 1U;  // kFollow alone
    restart();
  }
  void restart() {
    bank_.emplace(reports_, options_, []() noexcept { return now_; });
  }

  Bytes ask(const Bytes& request) { return ask(request, session_); }
  Bytes ask(const Bytes& request, ClientSession& session) {
    PduBuffer reply;
    const std::size_t size = answer_request(*bank_, session, request, reply);
    return Bytes(reply.begin(), reply.begin() + static_cast<std::ptrdiff_t>(size));
  }
  std::uint16_t read_one(std::uint16_t address) { return registers_of(ask(read_pdu(address, 1))).at(0); }
  Bytes write_one(std::uint16_t address, std::uint16_t value) { return ask(Bytes{6} + be16(address) + be16(value)); }
  static Bytes write_pdu(unsigned first, const std::vector<unsigned>& values) {
    Bytes pdu = Bytes{16} + be16(first) + be16(static_cast<unsigned>(values.size())) +
                Bytes{static_cast<std::uint8_t>(2 * values.size())};
    for (const unsigned value : values) pdu = pdu + be16(value);
    return pdu;
  }
  static Bytes exception(std::uint8_t function, ModbusException code) {
    return {static_cast<std::uint8_t>(function | 0x80U), static_cast<std::uint8_t>(code)};
  }

  static inline MonoTime now_;
  test::WireBox reports_;
  ModbusOptions options_;
  std::optional<RegisterBank> bank_;
  ClientSession session_;
};

TEST_F(ModbusRequest, BothReadFunctionsGiveTheSameRegisters) {
  const Bytes holding = ask(read_pdu(0, 125, 3)), input = ask(read_pdu(0, 125, 4));
  ASSERT_EQ(holding.size(), 252U);
  EXPECT_EQ(holding[0], 3);
  EXPECT_EQ(input[0], 4);
  EXPECT_EQ(holding[1], 250);
  std::vector<std::uint16_t> again = registers_of(input);
  --again[register_address("requests") + 1U];  // it counts the second request as well
  EXPECT_EQ(registers_of(holding), again);
  EXPECT_EQ(registers_of(holding)[0], kRegisterMapMagic);
}

TEST_F(ModbusRequest, AWindowShowsTheSameRegistersAsTheWholeMap) {
  const std::vector<std::uint16_t> all = registers_of(ask(read_pdu(0, 125)));
  const std::vector<std::uint16_t> window = registers_of(ask(read_pdu(16, 12)));
  EXPECT_EQ(window, std::vector<std::uint16_t>(all.begin() + 16, all.begin() + 28));
}

TEST_F(ModbusRequest, AddressesBeyondTheMapAreException02) {
  EXPECT_EQ(ask(read_pdu(kRegisterCount, 1)), exception(3, ModbusException::kIllegalAddress));
  EXPECT_EQ(ask(read_pdu(kRegisterCount - 1, 2)), exception(3, ModbusException::kIllegalAddress));
  EXPECT_EQ(ask(read_pdu(kRegisterCount - 124, 125, 4)), exception(4, ModbusException::kIllegalAddress));
  EXPECT_EQ(ask(read_pdu(65535, 125)), exception(3, ModbusException::kIllegalAddress)) << "the end must not wrap";
}

TEST_F(ModbusRequest, WrongQuantitiesAndLengthsAreException03) {
  EXPECT_EQ(ask(read_pdu(0, 0)), exception(3, ModbusException::kIllegalValue));
  EXPECT_EQ(ask(read_pdu(0, 126)), exception(3, ModbusException::kIllegalValue));
  EXPECT_EQ(ask(read_pdu(0, 65535)), exception(3, ModbusException::kIllegalValue));
  EXPECT_EQ(ask({3}), exception(3, ModbusException::kIllegalValue));
  EXPECT_EQ(ask({3, 0, 0, 0}), exception(3, ModbusException::kIllegalValue));
  EXPECT_EQ(ask(read_pdu(0, 1) + Bytes{0}), exception(3, ModbusException::kIllegalValue));
  EXPECT_EQ(ask({6, 0, 100, 0}), exception(6, ModbusException::kIllegalValue));
  EXPECT_EQ(ask({16, 0, 100, 0, 1, 2, 0}), exception(16, ModbusException::kIllegalValue)) << "a byte is missing";
  EXPECT_EQ(ask({16, 0, 100, 0, 2, 2, 0, 0}), exception(16, ModbusException::kIllegalValue)) << "counts disagree";
  EXPECT_EQ(ask({16, 0, 105, 0, 1, 4, 0, 0}), exception(16, ModbusException::kIllegalValue)) << "bytes are miscounted";
  EXPECT_EQ(ask({16, 0, 100, 0, 0, 0}), exception(16, ModbusException::kIllegalValue));
  EXPECT_EQ(ask({16, 0, 100, 0x7F, 0xFF, 0xFE, 0, 0}), exception(16, ModbusException::kIllegalValue));
}

TEST_F(ModbusRequest, OtherFunctionsAreException01) {
  for (const int function : {0, 1, 2, 5, 7, 8, 15, 17, 22, 23, 43, 127}) {
    const auto code = static_cast<std::uint8_t>(function);
    EXPECT_EQ(ask(Bytes{code, 0, 0, 0, 1}), exception(code, ModbusException::kIllegalFunction)) << function;
  }
}

TEST_F(ModbusRequest, WritesAreException01UnlessEnabled) {
  options_.allow_writes = false;
  restart();
  EXPECT_EQ(write_one(reg::kHold, 1), exception(6, ModbusException::kIllegalFunction));
  EXPECT_EQ(ask(write_pdu(reg::kHold, {1})), exception(16, ModbusException::kIllegalFunction));
  EXPECT_EQ(read_one(reg::kHold), 0);
}

TEST_F(ModbusRequest, OnlyWritableRegistersCanBeWritten) {
  for (unsigned address = 0; address < 200; ++address) {
    const RegisterEntry* entry = find_register(static_cast<std::uint16_t>(address));
    const bool writable = entry != nullptr && entry->access == RegisterAccess::kReadWrite;
    const Bytes reply = write_one(static_cast<std::uint16_t>(address), 0);
    EXPECT_EQ(reply == exception(6, ModbusException::kIllegalAddress), !writable) << address;
  }
  EXPECT_EQ(ask(write_pdu(101, {1, 2})), exception(16, ModbusException::kIllegalAddress)) << "102 is read-only";
}

TEST_F(ModbusRequest, WhatIsWrittenReadsBack) {
  EXPECT_EQ(ask(write_pdu(105, {4500, 0xFC18, 2000})), (Bytes{16, 0, 105, 0, 3}));
  EXPECT_EQ(registers_of(ask(read_pdu(105, 3))), (std::vector<std::uint16_t>{4500, 0xFC18, 2000}));
  EXPECT_EQ(write_one(105, 0xFFFF), (Bytes{6, 0, 105, 0xFF, 0xFF}));
  EXPECT_EQ(read_one(105), 0xFFFF) << "-0.01 deg";
}

TEST_F(ModbusRequest, ValuesOutOfRangeAreException03AndChangeNothing) {
  EXPECT_EQ(write_one(105, 18001), exception(6, ModbusException::kIllegalValue));
  EXPECT_EQ(write_one(106, static_cast<std::uint16_t>(-9001)), exception(6, ModbusException::kIllegalValue));
  EXPECT_EQ(write_one(104, 2), exception(6, ModbusException::kIllegalValue));
  EXPECT_EQ(ask(write_pdu(105, {100, 9001})), exception(16, ModbusException::kIllegalValue));
  EXPECT_EQ(read_one(105), 0) << "all or nothing";
}

TEST_F(ModbusRequest, HoldFreezesTheDataBlockButNeitherItsAgeNorOtherClients) {
  (void)write_one(reg::kHold, 1);
  WireReport next = test::known_report(now_);
  next.pose_sequence = 4711;
  next.pose.position_mm[0] = 9000;
  reports_.publish(next);
  now_ += std::chrono::milliseconds(100);
  const std::vector<std::uint16_t> held = registers_of(ask(read_pdu(0, 125)));
  EXPECT_EQ(held[reg::kPoseSequence], 66000U & 0xFFFFU);
  EXPECT_EQ(held[reg::kPoseSequenceCopy], 66000U & 0xFFFFU);
  EXPECT_EQ(held[reg::kX16], 2469);
  EXPECT_EQ(held[reg::kAge], 1123) << "held data grows old like any other";
  EXPECT_EQ(held[reg::kHold], 1);
  EXPECT_NE(held[reg::kStatus] & status_bit::kHeld, 0);

  ClientSession other;
  const std::vector<std::uint16_t> free = registers_of(ask(read_pdu(0, 125), other));
  EXPECT_EQ(free[reg::kPoseSequence], 4711);
  EXPECT_EQ(free[reg::kHold], 0);
}

TEST_F(ModbusRequest, HoldReleasesItselfAfterItsTime) {
  (void)write_one(reg::kHold, 1);
  WireReport next = test::known_report(now_);
  next.pose_sequence = 4711;
  reports_.publish(next);
  now_ += std::chrono::milliseconds(499);
  EXPECT_EQ(read_one(reg::kPoseSequence), 66000U & 0xFFFFU);
  now_ += std::chrono::milliseconds(1);
  EXPECT_EQ(read_one(reg::kPoseSequence), 4711);
  EXPECT_EQ(read_one(reg::kHold), 0);
}

TEST_F(ModbusRequest, AHeldPoseThatGrowsOldSaysThatItIsHeldAndNotThatNoFramesCome) {
  options_.hold_time = std::chrono::seconds(10);
  restart();
  (void)write_one(reg::kHold, 1);
  now_ += std::chrono::milliseconds(600);
  reports_.publish(test::known_report(now_));
  const std::vector<std::uint16_t> held = registers_of(ask(read_pdu(0, 125)));
  EXPECT_EQ(held[reg::kReason], static_cast<std::uint16_t>(Reason::kHeld));
  EXPECT_EQ(held[reg::kStatus] & status_bit::kValid, 0);
  EXPECT_NE(held[reg::kStatus] & status_bit::kStale, 0);
  ClientSession other;
  EXPECT_EQ(registers_of(ask(read_pdu(0, 125), other))[reg::kReason], 0);
  (void)write_one(reg::kHold, 0);
  EXPECT_EQ(read_one(reg::kReason), 0);
}

TEST_F(ModbusRequest, WritingHoldAgainTakesTheNewestAndZeroReleases) {
  (void)write_one(reg::kHold, 1);
  WireReport next = test::known_report(now_);
  next.pose_sequence = 4711;
  reports_.publish(next);
  (void)write_one(reg::kHold, 1);
  next.pose_sequence = 4712;
  reports_.publish(next);
  EXPECT_EQ(read_one(reg::kPoseSequence), 4711);
  (void)write_one(reg::kHold, 0);
  EXPECT_EQ(read_one(reg::kPoseSequence), 4712);
}

TEST_F(ModbusRequest, ACommandRunsOnceAndIsAcknowledged) {
  EXPECT_EQ(ask(write_pdu(reg::kCommand, {1, 5})), (Bytes{16, 0, 100, 0, 2}));
  EXPECT_EQ(registers_of(ask(read_pdu(100, 4))), (std::vector<std::uint16_t>{1, 5, 0, 1}));
  const auto command = bank_->try_take_command();
  ASSERT_TRUE(command);
  EXPECT_EQ(command->command, Command::kFollow);
  EXPECT_EQ(command->sequence, 5);
  EXPECT_FALSE(bank_->try_take_command());
  bank_->finish_command(5, true);
  EXPECT_EQ(registers_of(ask(read_pdu(100, 4))), (std::vector<std::uint16_t>{1, 5, 5, 2}));
  (void)write_one(reg::kCommandSequence, 5);
  EXPECT_FALSE(bank_->try_take_command()) << "the same number again is no new command";
}

TEST_F(ModbusRequest, ANewerCommandTakesTheOlderOnesPlaceWhichHasNoResultThen) {
  (void)ask(write_pdu(reg::kCommand, {1, 5}));
  ASSERT_EQ(bank_->try_take_command()->sequence, 5);
  EXPECT_EQ(ask(write_pdu(reg::kCommand, {1, 6})), (Bytes{16, 0, 100, 0, 2}));
  bank_->finish_command(5, true);
  EXPECT_EQ(registers_of(ask(read_pdu(100, 4))), (std::vector<std::uint16_t>{1, 6, 0, 1})) << "6 runs";
  (void)ask(write_pdu(reg::kCommand, {1, 7}));
  const auto command = bank_->try_take_command();
  ASSERT_TRUE(command);
  EXPECT_EQ(command->sequence, 7) << "6 was never taken and is forgotten";
  EXPECT_FALSE(bank_->try_take_command());
  bank_->finish_command(7, false);
  EXPECT_EQ(registers_of(ask(read_pdu(100, 4))), (std::vector<std::uint16_t>{1, 7, 7, 3}));
}

TEST_F(ModbusRequest, ACommandThatNobodyCanCarryOutIsException04AndAnUnknownOne03) {
  EXPECT_EQ(ask(write_pdu(reg::kCommand, {2, 1})), exception(16, ModbusException::kDeviceFailure));
  EXPECT_EQ(ask(write_pdu(reg::kCommand, {99, 1})), exception(16, ModbusException::kIllegalValue));
  EXPECT_EQ(registers_of(ask(read_pdu(100, 4))), (std::vector<std::uint16_t>{0, 0, 0, 0}));
}

TEST_F(ModbusRequest, AClientThatGivesWayOverwritesNoCommandThatItHasNotSeen) {
  const Bytes busy = exception(16, ModbusException::kDeviceBusy), done{16, 0, 100, 0, 2};
  ClientSession polite;
  const auto read = [&] { return registers_of(ask(read_pdu(100, 7), polite)); };
  (void)ask(write_pdu(reg::kGiveWay, {1}), polite);
  EXPECT_EQ(registers_of(ask(read_pdu(reg::kGiveWay, 1), polite)).at(0), 1);
  EXPECT_EQ(read_one(reg::kGiveWay), 0) << "nobody else's";
  for (const std::vector<unsigned>& theirs : {std::vector<unsigned>{reg::kCommand, 1, 5},
                                              {reg::kCommand, 1},
                                              {reg::kPanSetPoint, 4500},
                                              {reg::kTiltSetPoint, 77, 400}}) {
    const auto first = static_cast<std::uint16_t>(theirs[0]);
    (void)ask(write_pdu(first, {theirs.begin() + 1, theirs.end()}));
    const std::vector<std::uint16_t> as_written = registers_of(ask(read_pdu(100, 7)));
    EXPECT_EQ(ask(write_pdu(reg::kPanSetPoint, {1, 2}), polite), busy) << first;
    EXPECT_EQ(ask(write_pdu(reg::kTiltSetPoint, {2}), polite), busy) << first;
    EXPECT_EQ(ask(write_pdu(reg::kCommand, {1, 99}), polite), busy) << first;
    EXPECT_EQ(ask(write_pdu(reg::kClientWatchdog, {50}), polite), (Bytes{16, 0, 107, 0, 1})) << "its own";
    EXPECT_EQ(read(), as_written);
    EXPECT_EQ(ask(write_pdu(reg::kPanSetPoint, {1, 2}), polite), (Bytes{16, 0, 105, 0, 2})) << "it has read them";
    EXPECT_EQ(ask(write_pdu(reg::kCommand, {1, first}), polite), done) << "its own write is no other's";
    EXPECT_EQ(read(), (std::vector<std::uint16_t>{1, first, as_written[2], 1, 0, 1, 2}));
  }
  EXPECT_EQ(ask(write_pdu(reg::kCommand, {1, 6})), done) << "who does not give way";
  (void)ask(write_pdu(reg::kGiveWay, {0}), polite);
  EXPECT_EQ(ask(write_pdu(reg::kCommand, {1, 7}), polite), done);
  (void)ask(write_pdu(reg::kGiveWay, {1}), polite);
  (void)ask(write_pdu(reg::kCommand, {1, 8}));
  bank_->client_left(polite);
  EXPECT_EQ(ask(write_pdu(reg::kCommand, {1, 9}), polite), done) << "whoever is on the serial line next";
}

TEST_F(ModbusRequest, AnOwnWriteIsNoLookAtWhatOthersHaveWritten) {
  ClientSession polite;
  (void)ask(read_pdu(100, 7), polite);
  (void)ask(write_pdu(reg::kPanSetPoint, {4500}));
  (void)ask(write_pdu(reg::kTiltSetPoint, {7}), polite);  // over theirs, as it gives no way yet
  (void)ask(write_pdu(reg::kGiveWay, {1}), polite);
  EXPECT_EQ(ask(write_pdu(reg::kPanSetPoint, {0}), polite), exception(16, ModbusException::kDeviceBusy));
  EXPECT_EQ(registers_of(ask(read_pdu(reg::kPanSetPoint, 2), polite)), (std::vector<std::uint16_t>{4500, 7}));
  EXPECT_EQ(ask(write_pdu(reg::kPanSetPoint, {0}), polite), (Bytes{16, 0, 105, 0, 1})) << "it has read them";
}

TEST_F(ModbusRequest, ASilentClientsWatchdogFiresOnce) {
  (void)write_one(reg::kClientWatchdog, 300);
  now_ += std::chrono::milliseconds(299);
  EXPECT_TRUE(bank_->check_watchdog(session_));
  EXPECT_FALSE(bank_->try_take_command());
  now_ += std::chrono::milliseconds(1);
  EXPECT_FALSE(bank_->check_watchdog(session_));
  const auto command = bank_->try_take_command();
  ASSERT_TRUE(command);
  EXPECT_TRUE(command->from_watchdog);
  EXPECT_EQ(command->command, Command::kFollow);
  EXPECT_FALSE(bank_->try_take_command());
  EXPECT_EQ(read_one(reg::kClientWatchdog), 0);
}

TEST_F(ModbusRequest, ALateRequestDoesNotHideThatTheWatchdogWasDue) {
  (void)write_one(reg::kClientWatchdog, 300);
  now_ += std::chrono::milliseconds(301);
  (void)read_one(0);
  EXPECT_TRUE(bank_->try_take_command());
}

TEST_F(ModbusRequest, AClientThatLeavesFiresItsWatchdog) {
  (void)write_one(reg::kClientWatchdog, 300);
  bank_->client_left(session_);
  EXPECT_TRUE(bank_->try_take_command());
}

TEST_F(ModbusRequest, RequestsAndExceptionsAreCounted) {
  (void)ask(read_pdu(0, 1));
  (void)ask(read_pdu(0, 0));
  EXPECT_EQ(bank_->counters.requests.load(), 2U);
  EXPECT_EQ(bank_->counters.exceptions.load(), 1U);
  EXPECT_EQ(read_one(reg::kExceptions), 1);
  EXPECT_EQ(registers_of(ask(read_pdu(register_address("requests"), 2))), (std::vector<std::uint16_t>{0, 4}));
}

TEST_F(ModbusRequest, EveryByteStringGetsAWellFormedReply) {
  const std::string name = testing::UnitTest::GetInstance()->current_test_info()->name();
  std::seed_seq seed(name.begin(), name.end());
  std::mt19937 random(seed);
  const std::array<std::uint8_t, 8> functions = {3, 4, 6, 16, 0, 5, 0x83, 0xFF};
  for (int i = 0; i < 200000; ++i) {
    Bytes request(1 + random() % kMaxPdu);
    for (std::uint8_t& byte : request) byte = static_cast<std::uint8_t>(random());
    request[0] = functions[random() % functions.size()];
    if (request.size() > 6 && random() % 2 == 0) {  // near the truth, where mistakes would be
      request.resize(random() % 2 == 0 ? 5 : request.size());
      request[1] = 0, request[3] = 0, request[2] = static_cast<std::uint8_t>(random() % 130);
      if (request.size() > 5)
        request[4] = static_cast<std::uint8_t>((request.size() - 6) / 2),
        request[5] = static_cast<std::uint8_t>(2 * request[4]);
    }
    const Bytes reply = ask(request);
    ASSERT_GE(reply.size(), 2U);
    if ((reply[0] & kExceptionFlag) != 0) {
      ASSERT_EQ(reply.size(), 2U);
      ASSERT_GE(reply[1], 1);
      ASSERT_LE(reply[1], 6);
    } else if (reply[0] == 3 || reply[0] == 4) {
      ASSERT_EQ(reply.size(), 2U + reply[1]);
    } else {
      ASSERT_EQ(reply.size(), 5U);
    }
  }
}

}  // namespace
}  // namespace ninedot
