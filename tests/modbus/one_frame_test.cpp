/// A reply is of one frame, under load: clients read the whole map while frames arrive, and every number that they read
/// must follow from the one sequence number beside it.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>
#include <vector>

#include "drivers/modbus/server.h"
#include "tests/modbus/publisher.h"
#include "tests/modbus/raw_client.h"
#include "tests/support/sanitizers.h"

namespace ninedot {
namespace {

constexpr int kClients = 8;
constexpr int kReads = test::kSanitized ? 40'000 : 1'000'000;  // of all clients together
constexpr int kInFlight = 20;  // requests sent ahead: the reads of a minute in a few seconds

struct Count {
  std::atomic<int> reads{0}, torn{0}, short_replies{0}, went_back{0};
  std::atomic<std::uint32_t> frames_seen{0};
};

bool is_of_one_frame(std::span<const std::uint16_t> registers) {
  const RegisterReader reader(registers);
  const std::uint32_t sequence = reader.integer(reg::kPoseSequence);
  if (sequence != reader.integer(reg::kPoseSequenceCopy) || sequence != reader.integer(reg::kHeartbeat)) return false;
  if (sequence != reader.integer(reg::kLandmarkId) || sequence != reader.integer(reg::kDotsUsed)) return false;
  // Sequence numbers of this test stay below 30000, so that 16 bits of 0.5 mm hold one of them as z.
  const double n = sequence;
  return reader.value(reg::kX32) == n && reader.value(reg::kX32 + 2) == -n && reader.value(reg::kX32 + 4) == 2 * n &&
         reader.value(reg::kXFloat) == n && reader.value(reg::kXFloat + 2) == -n &&
         reader.value(reg::kXFloat + 4) == 2 * n && (n > 16383 || reader.value(reg::kX16) == n);
}

constexpr std::uint16_t kRead = 125;  // registers, as many as one request reads

void read_many(std::uint16_t port, int reads, Count& count) {
  const test::RawClient client(port);
  const test::Bytes request = test::tcp_frame(test::read_pdu(0, kRead));
  test::Bytes batch;
  for (int i = 0; i < kInFlight; ++i) batch.insert(batch.end(), request.begin(), request.end());
  constexpr std::size_t kReplyBytes = 9 + 2 * kRead;
  std::uint32_t newest = 0;
  for (int done = 0; done < reads; done += kInFlight) {
    client.send(batch);
    const test::Bytes replies = client.receive(kInFlight * kReplyBytes, std::chrono::seconds(30));
    if (replies.size() != kInFlight * kReplyBytes) {
      ++count.short_replies;
      return;
    }
    for (std::size_t i = 0; i < kInFlight; ++i) {
      const auto reply = replies.begin() + static_cast<std::ptrdiff_t>(i * kReplyBytes);
      const std::vector<std::uint16_t> registers = test::registers_of(test::Bytes(reply + 7, reply + kReplyBytes));
      if (!is_of_one_frame(registers)) ++count.torn;
      const std::uint32_t sequence = registers[reg::kPoseSequence];
      if (sequence < newest) ++count.went_back;
      if (sequence != newest) ++count.frames_seen;
      newest = sequence;
    }
    count.reads += kInFlight;
  }
}

class OneFrame : public testing::TestWithParam<double> {};

TEST_P(OneFrame, HoldsForEveryReadOfSeveralClientsWhileFramesArrive) {
  test::WireBox reports(test::report_number(0));
  ModbusOptions options;
  options.tcp.emplace().port = 0;
  const ModbusServer server(reports, options);
  Count count;

  std::uint32_t published = 0;
  {
    const test::Publisher publisher(reports, GetParam());
    std::vector<std::thread> clients;
    for (int i = 0; i < kClients; ++i)
      clients.emplace_back([&] { read_many(server.tcp_port(), kReads / kClients, count); });
    for (std::thread& client : clients) client.join();
    published = publisher.published();
  }
  ASSERT_LT(published, 30000U) << "the sequence's values have begun anew; the test took too long to mean anything";
  EXPECT_GE(count.reads, kReads);
  EXPECT_EQ(count.torn, 0);
  EXPECT_EQ(count.short_replies, 0);
  EXPECT_EQ(count.went_back, 0);
  EXPECT_GT(count.frames_seen, 10U) << "no frames arrived meanwhile: nothing was proved";
  std::printf("%d reads by %d clients, %u frames published, %u changes seen\n", count.reads.load(), kClients, published,
              count.frames_seen.load());
}

INSTANTIATE_TEST_SUITE_P(At, OneFrame, testing::Values(35.0, 200.0, 1000.0),
                         [](const auto& rate) { return std::to_string(static_cast<int>(rate.param)) + "Hz"; });

/// The proof above is worth something only if the check can fail.
TEST(OneFrameCheck, RejectsABlockMixedFromTwoFrames) {
  ServerState server;
  server.now = mono_now();
  RegisterBlock block = encode_registers(test::report_number(7), {}, server, {});
  EXPECT_TRUE(is_of_one_frame(block));
  const RegisterBlock other = encode_registers(test::report_number(8), {}, server, {});
  for (const std::uint16_t address :
       std::array<std::uint16_t, 5>{reg::kPoseSequenceCopy, reg::kHeartbeat, reg::kX16, reg::kX32 + 1, reg::kXFloat}) {
    RegisterBlock mixed = block;
    mixed[address] = other[address];
    EXPECT_FALSE(is_of_one_frame(mixed)) << address;
  }
}

}  // namespace
}  // namespace ninedot
