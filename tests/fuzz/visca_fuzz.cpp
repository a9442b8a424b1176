/// Whatever a camera says, and whenever: what is sent stays well-formed, one packet at a time is on its way, and the
/// clock that the dialogue asks for never stands still. Each step is a byte that says what happens, and what it needs:
/// bytes heard, time that goes by, an order.
#include <algorithm>
#include <cstdint>
#include <span>

#include "base/contract.h"
#include "drivers/servo/visca_dialogue.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

void check(const ViscaPacket& packet, int address) {
  const std::span<const std::uint8_t> bytes = packet.bytes();
  EXPECTS(bytes.size() >= 3 && bytes.size() <= kMaxViscaPacket && bytes.back() == 0xFF);
  EXPECTS(bytes[0] == 0x88 || bytes[0] == 0x80 + address);
  EXPECTS(std::all_of(bytes.begin() + 1, bytes.end() - 1, [](std::uint8_t byte) { return byte < 0x80; }));
}

void speak(ViscaDialogue& dialogue, MonoTime now, int address) {
  if (const auto packet = dialogue.next_packet(now)) {
    check(*packet, address);
    EXPECTS(!dialogue.next_packet(now));
  }
  EXPECTS(dialogue.is_lost(now) || dialogue.wake_at() > now);
  EXPECTS(dialogue.running() >= 0 && dialogue.running() <= 15);
}

}  // namespace
}  // namespace ninedot

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t count) {
  using namespace ninedot;
  if (count < 1) return 0;
  ViscaOptions options;
  options.address = 1 + bytes[0] % 7;
  if ((bytes[0] & 0x80U) != 0) options.zoom = 0x200;
  const int address = options.address;
  ViscaDialogue dialogue(options);
  MonoTime now = mono_from_ns(1'000'000'000);
  dialogue.begin(now);
  speak(dialogue, now, address);
  std::uint32_t sequence = 0;
  const std::span<const std::uint8_t> input(bytes + 1, count - 1);
  for (std::size_t at = 0; at < input.size();) {
    const unsigned what = input[at] >> 6U, size = input[at] & 0x3FU;
    ++at;
    if (what == 0) {  // heard: so many bytes
      const std::size_t length = std::min<std::size_t>(size, input.size() - at);
      dialogue.receive(input.subspan(at, length), now);
      at += length;
    } else if (what == 1) {
      now += size * 10ms;
    } else if (what == 2) {
      dialogue.order({ViscaOrder::Kind::kMove, {static_cast<std::int16_t>(size * 13), 1}, ++sequence});
    } else {
      dialogue.order({ViscaOrder::Kind::kStop, {}, ++sequence});
    }
    speak(dialogue, now, address);
    if (dialogue.is_lost(now)) {
      EXPECTS(dialogue.problem(now) != ViscaProblem::kNone);
      dialogue.begin(now);
      speak(dialogue, now, address);
    }
  }
  return 0;
}
