/// Whatever bytes arrive: on TCP's inside (one request) and on the serial line (a stream with silences), nothing
/// crashes and every reply is well-formed. The first byte chooses.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

#include "base/contract.h"
#include "drivers/modbus/register_bank.h"
#include "drivers/modbus/request.h"
#include "drivers/modbus/rtu_receiver.h"
#include "tests/proto/wire_box.h"

namespace ninedot {
namespace {

void answer(RegisterBank& bank, std::span<const std::uint8_t> request) {
  ClientSession session;
  PduBuffer reply;
  const std::size_t size = answer_request(bank, session, request, reply);
  EXPECTS(size >= 2 && size <= reply.size());
  EXPECTS((reply[0] & 0x7FU) == (request[0] & 0x7FU));
  (void)bank.try_take_command();
}

}  // namespace
}  // namespace ninedot

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace ninedot;
  static const test::WireBox reports;
  static const ModbusOptions options = [] {
    ModbusOptions all;
    all.allow_writes = true;
    all.supported_commands = ~0U;
    return all;
  }();
  if (size < 2) return 0;
  RegisterBank bank(reports, options);
  const std::span<const std::uint8_t> input(bytes + 1, size - 1);
  if (bytes[0] % 2 == 0) {
    answer(bank, input.first(std::min(input.size(), kMaxPdu)));
    return 0;
  }
  // A length, that many bytes, a silence, and so on; length 0: a long silence.
  RtuReceiver receiver(1);
  for (std::size_t at = 0; at < input.size();) {
    const std::size_t length = std::min<std::size_t>(input[at], input.size() - at - 1);
    if (input[at++] == 0) receiver.give_up();
    receiver.receive(input.subspan(at, length));
    at += length;
    if (const auto request = receiver.end_of_frame()) answer(bank, request->pdu);
  }
  return 0;
}
