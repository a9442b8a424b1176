/// Clients that misbehave never delay the others by more than 50 ms, and never the frame loop.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <functional>
#include <memory>
#include <thread>
#include <vector>

#include "drivers/modbus/server.h"
#include "tests/modbus/publisher.h"
#include "tests/modbus/raw_client.h"
#include "tests/support/sanitizers.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;
using test::Bytes;
using test::operator+;
using test::RawClient;
using test::read_pdu;
using test::tcp_frame;

constexpr std::chrono::milliseconds kDelayLimit = 50ms;
constexpr std::chrono::milliseconds kMeasured = test::kSanitized ? 1000ms : 2000ms;

/// Does wrong for as long as it is told to.
using Misbehaviour = std::function<void(std::uint16_t port, const std::atomic<bool>& stop)>;

void half_frames(std::uint16_t port, const std::atomic<bool>& stop) {
  const Bytes frame = tcp_frame(read_pdu(0, 125));
  while (!stop) {
    const RawClient client(port);
    client.send(Bytes(frame.begin(), frame.begin() + 9));
    std::this_thread::sleep_for(5ms);
  }
}

void wrong_requests(std::uint16_t port, const std::atomic<bool>& stop) {
  const RawClient client(port);
  const std::vector<Bytes> wrong = {read_pdu(0, 0), read_pdu(0, 2000),   read_pdu(60000, 10),
                                    {99},           {16, 0, 0, 0, 1, 2}, {3}};
  for (std::size_t i = 0; !stop; ++i) (void)client.ask(wrong[i % wrong.size()]);
}

void not_modbus(std::uint16_t port, const std::atomic<bool>& stop) {
  while (!stop) {
    const RawClient client(port);
    client.send(Bytes(300, 0xA5));
    (void)client.is_closed(100ms);
  }
}

void opened_and_never_used(std::uint16_t port, const std::atomic<bool>& stop) {
  const RawClient first(port), second(port), third(port);
  while (!stop) std::this_thread::sleep_for(5ms);
}

/// Asks for the whole map as fast as it can, and never reads a reply.
void slow_reader(std::uint16_t port, const std::atomic<bool>& stop) {
  const RawClient client(port, 2048);
  const Bytes request = tcp_frame(read_pdu(0, 125));
  Bytes flood;
  for (int i = 0; i < 50; ++i) flood = flood + request;
  while (!stop)
    if (client.try_send(flood) < static_cast<long>(flood.size())) std::this_thread::sleep_for(1ms);
}

/// Asks without a pause and reads its replies: greedy, but within the protocol.
void flood(std::uint16_t port, const std::atomic<bool>& stop) {
  const RawClient client(port);
  Bytes batch;
  for (unsigned i = 0; i < 100; ++i) batch = batch + tcp_frame(read_pdu(0, 125), i);
  while (!stop) {
    client.send(batch);
    (void)client.receive(100 * 259);
  }
}

struct Worst {
  std::chrono::nanoseconds reply{}, publish{};
};

/// The longest that a well-behaved client waited for a reply, and the frame loop for its mailbox.
Worst measure(const std::vector<Misbehaviour>& misbehaviours) {
  test::WireBox reports;
  ModbusOptions options;
  options.tcp.emplace().port = 0;
  const ModbusServer server(reports, options);
  Worst worst;
  const test::Publisher publisher(reports, 200);
  const RawClient good(server.tcp_port());
  EXPECT_FALSE(good.ask(read_pdu(0, 40)).empty());
  std::atomic<bool> stop{false};
  std::vector<std::thread> bad;
  for (const Misbehaviour& misbehave : misbehaviours) bad.emplace_back([&] { misbehave(server.tcp_port(), stop); });
  for (const MonoTime end = mono_now() + kMeasured; mono_now() < end;) {
    const MonoTime asked_at = mono_now();
    const Bytes reply = good.ask(read_pdu(0, 40));
    worst.reply = std::max<std::chrono::nanoseconds>(worst.reply, mono_now() - asked_at);
    EXPECT_EQ(reply.size(), 82U);
    std::this_thread::sleep_for(2ms);
  }
  stop = true;
  for (std::thread& thread : bad) thread.join();
  worst.publish = publisher.longest_publish();
  return worst;
}

double ms(std::chrono::nanoseconds duration) { return static_cast<double>(duration.count()) * 1e-6; }

void expect_others_undisturbed(const std::vector<Misbehaviour>& misbehaviours) {
  // A machine that is busy with other things stops any thread for 50 ms now and then: three attempts. A server that
  // waits for a client waits in each of them.
  constexpr int kAttempts = 3;
  Worst worst;
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    worst = measure(misbehaviours);
    std::printf("worst reply %.2f ms, worst publish %.3f ms\n", ms(worst.reply), ms(worst.publish));
    if (worst.reply < kDelayLimit && worst.publish < kDelayLimit) return;
  }
  EXPECT_LT(ms(worst.reply), ms(kDelayLimit));
  EXPECT_LT(ms(worst.publish), ms(kDelayLimit));
}

TEST(MisbehavingClients, HalfFramesDelayNobody) { expect_others_undisturbed({half_frames, half_frames}); }
TEST(MisbehavingClients, WrongQuantitiesAndFunctionsDelayNobody) {
  expect_others_undisturbed({wrong_requests, wrong_requests});
}
TEST(MisbehavingClients, BytesThatAreNotModbusDelayNobody) { expect_others_undisturbed({not_modbus}); }
TEST(MisbehavingClients, ConnectionsOpenedAndNeverUsedDelayNobody) {
  expect_others_undisturbed({opened_and_never_used});
}
TEST(MisbehavingClients, ReadersThatNeverReadTheirRepliesDelayNobody) {
  expect_others_undisturbed({slow_reader, slow_reader});
}
TEST(MisbehavingClients, AFloodOfRequestsDelaysNobody) { expect_others_undisturbed({flood, flood}); }
TEST(MisbehavingClients, AllOfThemTogetherDelayNobody) {
  expect_others_undisturbed({half_frames, wrong_requests, not_modbus, opened_and_never_used, slow_reader, flood});
}

TEST(MisbehavingClients, AReaderThatNeverReadsIsDroppedInTheEnd) {
  const test::WireBox reports;
  ModbusOptions options;
  options.tcp.emplace().port = 0;
  const ModbusServer server(reports, options);
  std::atomic<bool> stop{false};
  std::thread reader([&] { slow_reader(server.tcp_port(), stop); });
  const MonoTime deadline = mono_now() + 20s;
  while (server.counters().expired_connections == 0 && mono_now() < deadline) std::this_thread::sleep_for(10ms);
  EXPECT_EQ(server.counters().expired_connections, 1U);
  stop = true;
  reader.join();
}

}  // namespace
}  // namespace ninedot
