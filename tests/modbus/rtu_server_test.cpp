#include "drivers/modbus/rtu_server.h"

#include <gtest/gtest.h>
#include <pty.h>
#include <sys/ioctl.h>
#include <termios.h>

#include <filesystem>
#include <thread>

#include "base/baud_rates.h"
#include "base/startup_error.h"
#include "drivers/modbus/server.h"
#include "tests/modbus/raw_client.h"
#include "tests/proto/known_report.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;
using test::be16;
using test::Bytes;
using test::operator+;
using test::read_pdu;

Bytes rtu_frame(std::uint8_t unit, const Bytes& pdu) {
  Bytes frame = Bytes{unit} + pdu;
  const std::uint16_t crc = modbus_crc(frame);
  return frame + Bytes{static_cast<std::uint8_t>(crc & 0xFFU), static_cast<std::uint8_t>(crc >> 8U)};
}

/// A serial line whose far end the test holds; the server sees it under a name that stays the same when it is replaced.
class Line {
 public:
  Line() : name_(std::filesystem::temp_directory_path() / ("ninedot-rtu-test-" + std::to_string(::getpid()))) {
    connect();
  }
  ~Line() { std::filesystem::remove(name_); }
  void connect() {
    int near = -1, far = -1;
    std::array<char, 128> device{};
    if (::openpty(&near, &far, device.data(), nullptr, nullptr) != 0) throw std::runtime_error("openpty");
    termios raw{};
    (void)::tcgetattr(far, &raw);
    ::cfmakeraw(&raw);
    (void)::tcsetattr(far, TCSANOW, &raw);
    master_ = FileDescriptor(near), slave_ = FileDescriptor(far);
    std::filesystem::remove(name_);
    std::filesystem::create_symlink(device.data(), name_);
  }
  void cut() {
    std::filesystem::remove(name_);
    master_ = FileDescriptor();
    slave_ = FileDescriptor();
  }
  std::string name() const { return name_; }
  speed_t speed() const {
    termios now{};
    (void)::tcgetattr(slave_.get(), &now);
    return ::cfgetospeed(&now);
  }

  /// Others are refused by open(2), but for root.
  bool is_had_alone() const {
    int is_exclusive = 0;
    (void)::ioctl(slave_.get(), TIOCGEXCL, &is_exclusive);
    return is_exclusive != 0;
  }

  void send(const Bytes& bytes) const {
    ASSERT_EQ(::write(master_.get(), bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  }
  Bytes receive(std::size_t count, std::chrono::milliseconds timeout = 2s) const {
    Bytes got;
    const MonoTime deadline = mono_now() + timeout;
    while (got.size() < count) {
      const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - mono_now()).count();
      pollfd readable{master_.get(), POLLIN, 0};
      if (left < 0 || ::poll(&readable, 1, static_cast<int>(left) + 1) <= 0) break;
      std::array<std::uint8_t, 512> chunk;
      const ssize_t n = ::read(master_.get(), chunk.data(), std::min(chunk.size(), count - got.size()));
      if (n <= 0) break;
      got.insert(got.end(), chunk.begin(), chunk.begin() + n);
    }
    return got;
  }
  bool stays_silent(std::chrono::milliseconds time) const { return receive(1, time).empty(); }

 private:
  std::filesystem::path name_;
  FileDescriptor master_, slave_;
};

class ModbusRtu : public testing::Test {
 protected:
  ModbusRtu() {
    reports_.publish(test::known_report(mono_now()));
    options_.rtu.emplace().device = line_.name();
  }
  void start() { server_.emplace(reports_, options_); }
  void expect_answered(const Line& line) {
    line.send(rtu_frame(1, read_pdu(0, 2)));
    EXPECT_EQ(line.receive(9), rtu_frame(1, {3, 4, 0x9D, 0x09, 0, 1}));
  }

  test::WireBox reports_;
  ModbusOptions options_;
  Line line_;
  std::optional<ModbusServer> server_;
};

TEST_F(ModbusRtu, ARequestIsAnswered) {
  start();
  expect_answered(line_);
  line_.send(rtu_frame(1, read_pdu(0, 125, 4)));
  EXPECT_EQ(line_.receive(255).size(), 255U);
  EXPECT_EQ(server_->counters().requests, 2U);
}

TEST_F(ModbusRtu, TheLineIsHadAloneForAsLongAsItIsServed) {
  start();
  EXPECT_TRUE(line_.is_had_alone());
  server_.reset();
  EXPECT_FALSE(line_.is_had_alone());
}

TEST_F(ModbusRtu, EveryRateAndParityCanBeSet) {
  // What libmodbus does not know it replaces by 9600 in silence.
  constexpr std::array kSpeeds = {B1200,   B2400,   B4800,   B9600,   B19200,  B38400, B57600,
                                  B115200, B230400, B460800, B500000, B576000, B921600};
  static_assert(kSpeeds.size() == kBaudRates.size());
  for (std::size_t i = 0; i < kBaudRates.size(); ++i) {
    for (const char parity : {'N', 'E', 'O'}) {
      options_.rtu->baud = kBaudRates[i], options_.rtu->parity = parity;
      start();
      EXPECT_EQ(line_.speed(), kSpeeds[i]) << kBaudRates[i];
      expect_answered(line_);
    }
  }
}

TEST_F(ModbusRtu, ExceptionsAreAnsweredWithACheckSum) {
  start();
  line_.send(rtu_frame(1, read_pdu(0, 126)));
  EXPECT_EQ(line_.receive(5), rtu_frame(1, {0x83, 3}));
  line_.send(rtu_frame(1, read_pdu(kRegisterCount, 1)));
  EXPECT_EQ(line_.receive(5), rtu_frame(1, {0x83, 2}));
  line_.send(rtu_frame(1, {43, 14, 1, 0}));
  EXPECT_EQ(line_.receive(5), rtu_frame(1, {0xAB, 1}));
}

TEST_F(ModbusRtu, ForeignTrafficIsPassedOverWithoutAStall) {
  start();
  for (int i = 0; i < 20; ++i) {
    line_.send(rtu_frame(2, read_pdu(0, 60)));
    std::this_thread::sleep_for(3ms);
    line_.send(rtu_frame(2, Bytes{3, 120} + Bytes(120, 1)));
    std::this_thread::sleep_for(3ms);
    const MonoTime asked_at = mono_now();
    expect_answered(line_);
    EXPECT_LT(mono_now() - asked_at, 500ms) << "libmodbus alone waits for the rest of a frame that never comes";
  }
  EXPECT_EQ(server_->counters().foreign_frames, 40U);
  EXPECT_EQ(server_->counters().bus_errors, 0U);
}

TEST_F(ModbusRtu, ABroadcastIsCarriedOutAndNotAnswered) {
  options_.allow_writes = true;
  start();
  line_.send(rtu_frame(0, {6, 0, 105, 0, 42}));
  EXPECT_TRUE(line_.stays_silent(100ms));
  line_.send(rtu_frame(0, read_pdu(0, 1)));
  EXPECT_TRUE(line_.stays_silent(100ms));
  line_.send(rtu_frame(1, read_pdu(105, 1)));
  EXPECT_EQ(line_.receive(7), rtu_frame(1, {3, 2, 0, 42}));
}

TEST_F(ModbusRtu, ABrokenCheckSumIsNotAnsweredAndTheNextRequestIs) {
  start();
  Bytes broken = rtu_frame(1, read_pdu(0, 2));
  broken.back() ^= 0x55U;
  line_.send(broken);
  EXPECT_TRUE(line_.stays_silent(100ms));
  EXPECT_EQ(server_->counters().bus_errors, 1U);
  EXPECT_EQ(server_->counters().unreadable_frames, 1U);
  expect_answered(line_);
}

TEST_F(ModbusRtu, HalfAFrameIsForgottenAndTheNextRequestIsAnswered) {
  start();
  line_.send({1, 3, 0, 0});
  std::this_thread::sleep_for(50ms);
  expect_answered(line_);
  line_.send({1, 3, 0, 0});  // and without waiting
  std::this_thread::sleep_for(3ms);
  expect_answered(line_);
}

TEST_F(ModbusRtu, AFrameTornByAnAdapterIsAnswered) {
  start();
  const Bytes frame = rtu_frame(1, read_pdu(0, 2));
  line_.send(Bytes(frame.begin(), frame.begin() + 5));
  std::this_thread::sleep_for(8ms);
  line_.send(Bytes(frame.begin() + 5, frame.end()));
  EXPECT_EQ(line_.receive(9), rtu_frame(1, {3, 4, 0x9D, 0x09, 0, 1}));
}

TEST_F(ModbusRtu, TheEchoOfAWrittenRegisterIsNotWrittenAgain) {
  options_.allow_writes = true;
  options_.rtu->baud = 1200;  // a slow line, on which the echo comes in time even on a busy machine
  start();
  const Bytes write = rtu_frame(1, {6, 0, 105, 0, 42});
  line_.send(write);
  ASSERT_EQ(line_.receive(write.size()), write);
  line_.send(write);
  EXPECT_TRUE(line_.stays_silent(300ms));
  EXPECT_EQ(server_->counters().requests, 1U);
}

TEST_F(ModbusRtu, ALineThatVanishesIsOpenedAgainAndCounted) {
  start();
  expect_answered(line_);
  line_.cut();
  const MonoTime deadline = mono_now() + 5s;
  while (server_->counters().serial_open && mono_now() < deadline) std::this_thread::sleep_for(5ms);
  EXPECT_FALSE(server_->counters().serial_open);
  EXPECT_EQ(server_->counters().serial_losses, 1U);
  EXPECT_EQ(server_->counters().bus_errors, 1U);
  line_.connect();
  while (!server_->counters().serial_open && mono_now() < deadline) std::this_thread::sleep_for(5ms);
  ASSERT_TRUE(server_->counters().serial_open);
  expect_answered(line_);
}

TEST_F(ModbusRtu, ALineThatComesLateIsServedOnceItIsThere) {
  line_.cut();
  start();
  EXPECT_FALSE(server_->counters().serial_open);
  EXPECT_EQ(server_->counters().serial_losses, 0U) << "it was never there";
  EXPECT_EQ(server_->serial_problem(), line_.name() +
                                           ": No such file or directory; connect the adapter, or correct "
                                           "the device of [modbus.rtu]");
  std::this_thread::sleep_for(150ms);  // one attempt in vain
  line_.connect();
  const MonoTime deadline = mono_now() + 5s;
  while (!server_->counters().serial_open && mono_now() < deadline) std::this_thread::sleep_for(5ms);
  EXPECT_EQ(server_->serial_problem(), "");
  expect_answered(line_);
}

TEST_F(ModbusRtu, ALineThatIsGoneSaysSoUntilItIsBack) {
  start();
  EXPECT_EQ(server_->serial_problem(), "");
  line_.cut();
  const MonoTime deadline = mono_now() + 5s;
  while (server_->serial_problem().empty() && mono_now() < deadline) std::this_thread::sleep_for(1ms);
  EXPECT_NE(server_->serial_problem().find(line_.name()), std::string::npos);
  line_.connect();
  while (!server_->serial_problem().empty() && mono_now() < deadline) std::this_thread::sleep_for(5ms);
  EXPECT_EQ(server_->serial_problem(), "");
}

TEST_F(ModbusRtu, StoppingDoesNotWaitForALineThatIsGone) {
  start();
  line_.cut();
  std::this_thread::sleep_for(300ms);
  const MonoTime stopped_at = mono_now();
  server_.reset();
  EXPECT_LT(mono_now() - stopped_at, 500ms);
}

TEST_F(ModbusRtu, TheLineIsListedOnceItHasAsked) {
  start();
  EXPECT_TRUE(server_->clients().empty());
  expect_answered(line_);
  const std::vector<ConnectedClient> clients = server_->clients();
  ASSERT_EQ(clients.size(), 1U);
  EXPECT_EQ(clients[0].address, line_.name() + " unit 1");
  EXPECT_EQ(clients[0].requests, 1U);
}

TEST_F(ModbusRtu, RtuAndTcpServeAtOnce) {
  options_.tcp.emplace().port = 0;
  start();
  const test::RawClient tcp(server_->tcp_port());
  for (int i = 0; i < 20; ++i) {
    expect_answered(line_);
    EXPECT_EQ(tcp.ask(read_pdu(0, 1)), (Bytes{3, 2, 0x9D, 0x09}));
  }
}

std::string start_error(const ModbusRtuOptions& rtu, ExitStatus expected) {
  const test::WireBox reports;
  ModbusOptions options;
  options.rtu = rtu;
  try {
    const ModbusServer server(reports, options);
  } catch (const StartupError& error) {
    EXPECT_EQ(error.status, expected);
    return error.what();
  }
  return "";
}

TEST(ModbusRtuStart, AMissingDeviceIsNoReasonToRefuse) {
  ModbusRtuOptions rtu;
  rtu.device = "/dev/ninedot-no-such-line";
  EXPECT_EQ(start_error(rtu, ExitStatus::kSuccess), "");
}

TEST(ModbusRtuStart, ADeviceThatIsNoSerialLineIsRefused) {
  ModbusRtuOptions rtu;
  for (const char* device : {"/dev/null", "/tmp", NINEDOT_SOURCE_DIR "/README.md"}) {
    rtu.device = device;
    EXPECT_NE(start_error(rtu, ExitStatus::kWrongUsage).find("this is no serial line"), std::string::npos) << device;
  }
}

TEST(ModbusRtuStart, ARateThatNoLineHasIsRefused) {
  ModbusRtuOptions rtu;
  rtu.baud = 115201;
  EXPECT_NE(start_error(rtu, ExitStatus::kWrongUsage).find("115201 baud"), std::string::npos);
}

}  // namespace
}  // namespace ninedot
