#include "drivers/modbus/tcp_server.h"

#include <gtest/gtest.h>

#include "base/startup_error.h"
#include "drivers/modbus/client.h"
#include "drivers/modbus/server.h"
#include "tests/modbus/raw_client.h"
#include "tests/proto/known_report.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;
using test::Bytes;
using test::operator+;
using test::RawClient;
using test::read_pdu;
using test::registers_of;
using test::tcp_frame;

class ModbusTcp : public testing::Test {
 protected:
  ModbusTcp() {
    reports_.publish(test::known_report(mono_now()));
    options_.tcp.emplace().port = 0;
  }
  void start() { server_.emplace(reports_, options_); }
  std::uint16_t port() const { return server_->tcp_port(); }

  /// Waits until a condition that another thread brings about holds.
  template <typename Condition>
  static bool soon(Condition condition) {
    const MonoTime deadline = mono_now() + 5s;
    while (!condition()) {
      if (mono_now() > deadline) return false;
      std::this_thread::sleep_for(1ms);
    }
    return true;
  }

  test::WireBox reports_;
  ModbusOptions options_;
  std::optional<ModbusServer> server_;
};

TEST_F(ModbusTcp, OurOwnClientReadsTheWholeMap) {
  start();
  auto client = ModbusTcpClient::connect("127.0.0.1", port(), 2s);
  ASSERT_TRUE(client) << client.error().text;
  std::array<std::uint16_t, kRegisterCount> registers{};
  ASSERT_TRUE(client->read_registers(0, std::span(registers).first(125)));
  ASSERT_TRUE(client->read_registers(125, std::span(registers).subspan(125)));
  const RegisterReader reader(registers);
  EXPECT_TRUE(reader.is_ninedot());
  EXPECT_NEAR(reader.value(reg::kX32), 1234.5678, 0.0005);
  EXPECT_EQ(reader.integer(reg::kConnectedClients), 1U);
}

TEST_F(ModbusTcp, OurOwnClientSaysWhyItFailed) {
  start();
  auto client = ModbusTcpClient::connect("127.0.0.1", port(), 2s);
  ASSERT_TRUE(client);
  std::array<std::uint16_t, 2> registers{};
  const auto refused = client->read_registers(kRegisterCount - 1, registers);
  ASSERT_FALSE(refused);
  EXPECT_STREQ(refused.error().text, "the server refused the request with a Modbus exception");
  const std::uint16_t dead_port = port();
  server_.reset();
  const auto nobody = ModbusTcpClient::connect("127.0.0.1", dead_port, 500ms);
  ASSERT_FALSE(nobody);
  EXPECT_EQ(nobody.error().os_errno, ECONNREFUSED);
}

TEST_F(ModbusTcp, OurOwnClientDoesNotWaitForEver) {
  // A server that accepts and never answers: the system's own backlog of a listening socket.
  FileDescriptor mute(::socket(AF_INET, SOCK_STREAM, 0));
  sockaddr_in any{};
  any.sin_family = AF_INET;
  any.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(::bind(mute.get(), reinterpret_cast<const sockaddr*>(&any), sizeof any), 0);
  ASSERT_EQ(::listen(mute.get(), 1), 0);
  socklen_t size = sizeof any;
  ASSERT_EQ(::getsockname(mute.get(), reinterpret_cast<sockaddr*>(&any), &size), 0);
  auto client = ModbusTcpClient::connect("127.0.0.1", ntohs(any.sin_port), 200ms);
  ASSERT_TRUE(client);
  std::array<std::uint16_t, 2> registers{};
  const auto result = client->read_registers(0, registers);
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().os_errno, ETIMEDOUT);
}

TEST_F(ModbusTcp, EveryUnitIsAnsweredAndGivenBackWithTheTransaction) {
  start();
  const RawClient client(port());
  for (const int unit : {0, 1, 17, 247, 255}) {
    client.send(tcp_frame(read_pdu(0, 1), 0xBEE0, static_cast<std::uint8_t>(unit)));
    EXPECT_EQ(client.receive(11), (Bytes{0xBE, 0xE0, 0, 0, 0, 5, static_cast<std::uint8_t>(unit), 3, 2, 0x9D, 0x09}));
  }
}

TEST_F(ModbusTcp, ARequestInSinglesBytesIsAnsweredOnceItIsWhole) {
  start();
  const RawClient client(port());
  for (const std::uint8_t byte : tcp_frame(read_pdu(0, 2))) {
    client.send({byte});
    std::this_thread::sleep_for(1ms);
  }
  EXPECT_EQ(registers_of(client.receive_pdu()), (std::vector<std::uint16_t>{0x9D09, 1}));
}

TEST_F(ModbusTcp, AHundredRequestsInOneGoAreAnsweredInOrder) {
  start();
  const RawClient client(port());
  Bytes all;
  for (unsigned i = 0; i < 100; ++i) all = all + tcp_frame(read_pdu(0, 125), i);
  client.send(all);
  for (unsigned i = 0; i < 100; ++i) {
    const Bytes reply = client.receive(259);
    ASSERT_EQ(reply.size(), 259U) << i;
    EXPECT_EQ(unsigned{reply[0]} << 8U | reply[1], i);
  }
}

TEST_F(ModbusTcp, AClientThatShutsItsSendingSideStillGetsItsReplies) {
  start();
  const RawClient client(port());
  Bytes all;
  for (unsigned i = 0; i < 20; ++i) all = all + tcp_frame(read_pdu(0, 125), i);
  client.send(all);
  ::shutdown(client.fd(), SHUT_WR);
  EXPECT_EQ(client.receive(20 * 259).size(), 20U * 259U);
  EXPECT_TRUE(client.is_closed(2s));
}

TEST_F(ModbusTcp, AHeaderThatIsNotModbusClosesTheConnectionAndCounts) {
  start();
  const std::vector<Bytes> wrong = {{0, 1, 0xAB, 0xCD, 0, 6, 1, 3, 0, 0, 0, 1},
                                    {0, 1, 0, 0, 0, 0, 1, 3, 0, 0, 0, 1},
                                    {0, 1, 0, 0, 0, 1, 1, 3},
                                    {0, 1, 0, 0, 0, 255, 1, 3},
                                    {'G', 'E', 'T', ' ', '/', ' ', 'H', 'T', 'T', 'P'}};
  for (const Bytes& bytes : wrong) {
    const RawClient client(port());
    client.send(bytes);
    EXPECT_TRUE(client.is_closed(2s));
  }
  EXPECT_TRUE(soon([&] { return server_->counters().bus_errors == wrong.size(); }));
}

TEST_F(ModbusTcp, ExceptionsLeaveTheConnectionOpen) {
  start();
  const RawClient client(port());
  EXPECT_EQ(client.ask(read_pdu(0, 126)), (Bytes{0x83, 3}));
  EXPECT_EQ(client.ask(read_pdu(kRegisterCount, 1)), (Bytes{0x83, 2}));
  EXPECT_EQ(client.ask({0x2B, 14, 1, 0}), (Bytes{0xAB, 1}));
  EXPECT_EQ(client.ask(read_pdu(0, 1)).size(), 4U);
  EXPECT_EQ(server_->counters().exceptions, 3U);
}

TEST_F(ModbusTcp, HoldEndsWithTheConnectionAndIsNobodyElses) {
  options_.allow_writes = true;
  options_.hold_time = 10s;
  start();
  const RawClient other(port());
  {
    const RawClient holder(port());
    (void)holder.ask({6, 0, 104, 0, 1});
    EXPECT_EQ(registers_of(holder.ask(read_pdu(104, 1))).at(0), 1);
    EXPECT_EQ(registers_of(other.ask(read_pdu(104, 1))).at(0), 0);
  }
  const RawClient again(port());
  EXPECT_EQ(registers_of(again.ask(read_pdu(104, 1))).at(0), 0);
}

TEST_F(ModbusTcp, AClientThatHangsUpFiresItsWatchdog) {
  options_.allow_writes = true;
  options_.supported_commands = 1U << 1U;
  start();
  { (void)RawClient(port()).ask({6, 0, 107, 0xFF, 0xFF}); }
  std::optional<ClientCommand> command;
  EXPECT_TRUE(soon([&] { return (command = server_->try_take_command()).has_value(); }));
  EXPECT_TRUE(command->from_watchdog);
}

TEST_F(ModbusTcp, ASilentClientFiresItsWatchdogInTime) {
  options_.allow_writes = true;
  options_.supported_commands = 1U << 1U;
  start();
  const RawClient client(port());
  (void)client.ask({6, 0, 107, 0, 100});
  const MonoTime asked_at = mono_now();
  EXPECT_TRUE(soon([&] { return server_->try_take_command().has_value(); }));
  EXPECT_GT(mono_now() - asked_at, 80ms);
}

TEST_F(ModbusTcp, IdleConnectionsAreClosedAndBusyOnesAreNot) {
  options_.tcp->idle_timeout = 400ms;
  start();
  const RawClient idle(port()), half(port()), busy(port());
  half.send({0, 1, 0, 0});
  for (int i = 0; i < 8; ++i) {
    ASSERT_FALSE(busy.ask(read_pdu(0, 1)).empty());
    half.send({});
    std::this_thread::sleep_for(100ms);
  }
  EXPECT_TRUE(idle.is_closed(0ms));
  EXPECT_TRUE(half.is_closed(0ms)) << "half a request is none";
  EXPECT_FALSE(busy.is_closed(0ms));
  EXPECT_EQ(server_->counters().expired_connections, 2U);
}

TEST_F(ModbusTcp, ConnectionsAreLimitedInNumber) {
  options_.tcp->max_clients = 3;
  start();
  std::vector<RawClient> served;
  for (int i = 0; i < 3; ++i) {
    served.emplace_back(port());
    ASSERT_FALSE(served.back().ask(read_pdu(0, 1)).empty());
  }
  const RawClient one_too_many(port());
  EXPECT_TRUE(one_too_many.is_closed(2s));
  for (const RawClient& client : served) EXPECT_FALSE(client.ask(read_pdu(0, 1)).empty());
  EXPECT_EQ(server_->counters().refused_connections, 1U);
}

TEST_F(ModbusTcp, AConnectionThatNeverAskedMakesRoomForOneThatDoes) {
  options_.tcp->max_clients = 2;
  start();
  const RawClient silent(port()), served(port());
  ASSERT_FALSE(served.ask(read_pdu(0, 1)).empty());
  std::this_thread::sleep_for(2200ms);
  const RawClient newcomer(port());
  EXPECT_FALSE(newcomer.ask(read_pdu(0, 1)).empty());
  EXPECT_TRUE(silent.is_closed(1s));
  EXPECT_FALSE(served.ask(read_pdu(0, 1)).empty());
}

TEST_F(ModbusTcp, PeersThatAreNotOnTheListAreTurnedAway) {
  options_.tcp->allow = {"192.0.2.0/24"};
  start();
  const RawClient stranger(port());
  EXPECT_TRUE(stranger.is_closed(2s));
  EXPECT_TRUE(soon([&] { return server_->counters().refused_connections == 1; }));

  options_.tcp->allow = {"192.0.2.0/24", "127.0.0.0/8"};
  start();
  const RawClient listed(port());
  EXPECT_FALSE(listed.ask(read_pdu(0, 1)).empty());
}

TEST_F(ModbusTcp, ClientsAreListedWithTheirAddresses) {
  start();
  const RawClient client(port());
  (void)client.ask(read_pdu(0, 1));
  (void)client.ask(read_pdu(0, 1));
  const std::vector<ConnectedClient> clients = server_->clients();
  ASSERT_EQ(clients.size(), 1U);
  EXPECT_EQ(clients[0].address.substr(0, 10), "127.0.0.1:");
  EXPECT_EQ(clients[0].requests, 2U);
}

TEST_F(ModbusTcp, APortInUseIsOneLineThatNamesTheAddress) {
  start();
  ModbusOptions second = options_;
  second.tcp->port = port();
  try {
    const ModbusServer server(reports_, second);
    FAIL() << "two servers on one port";
  } catch (const StartupError& error) {
    EXPECT_EQ(error.status, ExitStatus::kWorkFailed);
    EXPECT_EQ(std::string(error.what()), "Modbus TCP cannot listen on 127.0.0.1:" + std::to_string(port()) +
                                             ": Address already in use; stop the program that uses it, or configure "
                                             "another port in [modbus.tcp]");
  }
}

TEST_F(ModbusTcp, AnAddressThatIsNoneIsWrongUsage) {
  options_.tcp->listen = "plc.example";
  try {
    start();
    FAIL();
  } catch (const StartupError& error) {
    EXPECT_EQ(error.status, ExitStatus::kWrongUsage);
    EXPECT_NE(std::string(error.what()).find("plc.example"), std::string::npos);
  }
}

TEST_F(ModbusTcp, AnAddressOfNoInterfaceFailsTheWork) {
  options_.tcp->listen = "192.0.2.1";
  try {
    start();
    FAIL();
  } catch (const StartupError& error) {
    EXPECT_EQ(error.status, ExitStatus::kWorkFailed);
    EXPECT_NE(std::string(error.what()).find("192.0.2.1"), std::string::npos);
  }
}

TEST_F(ModbusTcp, ARestartListensAgainAtOnce) {
  start();
  const std::uint16_t first_port = port();
  const RawClient client(first_port);
  (void)client.ask(read_pdu(0, 1));
  server_.reset();
  options_.tcp->port = first_port;
  EXPECT_NO_THROW(start());
}

}  // namespace
}  // namespace ninedot
