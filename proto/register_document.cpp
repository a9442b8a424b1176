#include "proto/register_document.h"

#include <fmt/format.h>

#include <bit>
#include <iterator>
#include <string_view>

#include "proto/register_map.h"

namespace ninedot {
namespace {

std::string_view type_name(RegisterType type) {
  switch (type) {
    case RegisterType::kU16:
      return "uint16";
    case RegisterType::kI16:
      return "int16";
    case RegisterType::kU32:
      return "uint32";
    case RegisterType::kI32:
      return "int32";
    case RegisterType::kF32:
      return "float32";
    case RegisterType::kBits16:
      return "bits";
    case RegisterType::kCounter16:
      return "counter16";
    case RegisterType::kCounter32:
      return "counter32";
  }
  return "";
}

std::string_view kind_name(MetricKind kind) {
  return kind == MetricKind::kCounter ? "counter" : kind == MetricKind::kGauge ? "gauge" : "flag";
}

std::string_view access_name(RegisterAccess access) { return access == RegisterAccess::kRead ? "r" : "rw"; }

bool is_bits_or_float(const RegisterEntry& entry) {
  return entry.type == RegisterType::kBits16 || entry.type == RegisterType::kF32;
}

std::string address_text(const RegisterEntry& entry) {
  return entry.words() == 1 ? fmt::format("{}", entry.address)
                            : fmt::format("{}-{}", entry.address, entry.address + entry.words() - 1);
}

std::string step_text(const RegisterEntry& entry) {
  if (is_bits_or_float(entry)) return std::string(entry.unit);
  if (entry.unit.empty()) return entry.scale == 1 ? "" : fmt::format("{}", entry.scale);
  return fmt::format("{} {}{}", entry.scale, entry.unit, entry.scale_is_configured ? " (configurable)" : "");
}

std::string range_text(const RegisterEntry& entry) {
  if (is_bits_or_float(entry)) return "";
  return fmt::format("{}..{}", entry.lowest, entry.highest);
}

static_assert(kRegisterCount == 168, "the texts below say where the map ends");
constexpr std::string_view kMarkdownHead = R"(# Register map

Made by `ninedot registers --format md` from the table in `proto/register_map.h`; do not edit.

Addresses are 0-based, as on the wire; a tool that counts from 1 (mbpoll without `-0`, 40001-style notation) needs one
more. Function codes 03 (holding registers) and 04 (input registers) show the same contents, because controllers differ
in what they can read. One request reads at most 125 registers: from 0 on all but the angles and who the
device is, from 42 on all with them. The map ends at address 167. **Whatever one reply holds is from one frame.**

Try it:

    mbpoll -m tcp -p 1502 -0 -1 -r 0 -c 10 -t 4:hex 127.0.0.1      # magic 0x9D09 first
    mbpoll -m tcp -p 1502 -0 -1 -r 16 -c 6 -t 4:int -B 127.0.0.1   # x y z in 0.001 mm, rotation in 0.001 deg
    mbpoll -m tcp -p 1502 -0 -1 -r 40 -c 7 -t 4:float -B 127.0.0.1 # x y z in mm and the quaternion
    mbpoll -m tcp -p 1502 -0 -1 -r 127 -c 3 -t 4:int -B 127.0.0.1  # yaw pitch roll in 0.001 deg

## How to use it

1. Commission: register 0 is 0x9D09; 80-85 read as -1, 0x12345678 and 123456.0 when signs and word order are right.
2. In each cycle read 0-39 (or 0-53) in one request. Use the pose only while status bit `valid` is set and `age` is below
   what your motion allows.
3. If the block is read in several requests, compare 3 with 39, or hold it (104).
4. Angles instead of rotation vectors, a FANUC's, a KUKA's or the robot's heading: 125-145, read in one request, and 145
   compared with 3. Register 125 says whose pose it is, 126 which angles they are.
5. `heartbeat` (2) stands still: the device is not processing frames, whatever else the registers say.

No landmark in view is not an exception: the last pose stays, `valid` is 0, `reason` says why, the age grows and
saturates. A pose that is older than the limit (0.5 s) is `stale` and never `valid`.

## Numbers

- 16-bit registers: unsigned, or signed in two's complement. Value = register times step.
- 32-bit integers: high word first, always. float32 (IEEE 754): high word first, or low word first when so configured
  (`float_word_order`).
- Values are rounded to the nearest step and saturate at the ends of their range, they never wrap; only counters do,
  to 0. Unknown: -32768 or -2147483648 in signed registers, the upper end of the range in unsigned ones, NaN in float32.
- World frame: Z up. Position is the camera's optical centre. The rotation turns camera vectors (x right, y down,
  z forward) into world vectors; as rotation vector its direction is the axis and its length the angle, 0..180 deg.
- That is so unless the configuration says otherwise: `pose` of its `[outputs]` puts the camera in the landmark's frame or the
  robot's body in the world into the very same registers, with their uncertainties and the rival (register 125 says which it
  is), and `euler` chooses the angles. Where the pitch is +-90 deg only one sum of the other two angles is known:
  roll (W, C) is then 0. A level camera has a roll of -90 deg: its z looks forward; for a heading take the body.

## Registers

)";

constexpr std::string_view kMarkdownTail = R"(
## Writing

Off unless configured (`allow_writes`); then function codes 06 and 16 write the registers marked `rw`, and reading
gives back what was written. A request that writes several registers is carried out whole or not at all.

- **Command**: write `command` and then `command_sequence`, or both in one request. A new sequence number starts the
  command; `command_result` becomes 1, and at its end 2 or 3, with the number in `command_acknowledge`.
  2 (done): the head stands where it was sent, within 0.15 deg or its dead band, and pan and tilt of the same reply say
  so; or it follows. 3 (failed): it does not answer, is inhibited, stands at the end of its range, or has not arrived
  after the time that its way takes at its fastest turn, a quarter of it and 5 s more; or a client watchdog took the head away. The
  order stays all the same: an inhibited head goes on when it may. Servos do not tell where they stand: for them it is
  where their pulses send them.
- **A newer command** takes the older one's place at once. `command_result` and `command_acknowledge` are then about
  the newer one; the older one has no result, and its number never appears in `command_acknowledge`.
- **Hold** belongs to the client that asks (a TCP connection, or the serial line): it freezes registers 2-59 and
  118-147 for that client alone, so that nobody can freeze what others see. Writing 1 again takes the newest frame and starts the time
  anew. It ends when 0 is written, when the connection ends, and by itself after 500 ms (`hold_ms`). Age, `stale`
  and `valid` go on meanwhile: held data grows old like any other, and then `reason` is 9, unless the held pose was not
  valid in the first place. Set-points and commands are shared by all clients.
- **Client watchdog** belongs to the client as well: if it is armed and the client sends no request in time, or its
  connection ends, the head goes back to following the landmark and the watchdog is off again.
- **Give way** (167) belongs to the client, too: a client that wrote 1 there never overwrites what another one has
  commanded. Its commands and set-points are refused (06) while another client has written any since its own last read;
  it reads again, sees what they are, and writes or leaves it. It ends when 0 is written, or the connection ends.
  `ninedot-web`'s page is such a client.

## Exceptions

| code | when |
|---|---|
| 01 | a function code other than 03 and 04, or 06 and 16 while writes are enabled |
| 02 | an address beyond 167, or a write to a register that is not marked `rw` |
| 03 | a quantity of 0 or above 125 (write: 123), a request whose length is wrong, a written value out of range |
| 04 | a command that this device can't carry out (no pan/tilt head) |
| 06 | a command or set-point of a client that gives way (167), and another one's came first |

## Addresses of devices and lines

- TCP: the connection is the address, so every unit identifier is answered, and given back in the reply. Requests may
  be sent without waiting for replies; they are answered in order.
- RTU: the configured unit alone is answered. Unit 0 (broadcast): writes are carried out, nothing is answered. Other
  units' requests and replies on the same line are passed over. A frame ends with 3.5 characters of silence (at least
  1.75 ms); a frame that the driver delivers in pieces is accepted up to 20 ms after its last piece.
- TCP connections are limited in number; one that sends no complete request for the idle time is closed, and when all
  places are taken, one that never sent any makes room.
)";

void append_metrics(std::string& out) {
  out += "\n| metric | kind | counted by |\n|---|---|---|\n";
  for (const Metric& metric : kMetrics)
    fmt::format_to(std::back_inserter(out), "| `{}` | {} | {} |\n", metric.name, kind_name(metric.kind),
                   metric.counted);
}

void append_codes(std::string& out, std::span<const RegisterCode> codes) {
  out += "\n| code | meaning |\n|---|---|\n";
  for (const RegisterCode& code : codes)
    fmt::format_to(std::back_inserter(out), "| {} | {} |\n", code.code, code.meaning);
}

void append_bits(std::string& out, std::span<const RegisterBit> bits) {
  out += "\n| bit | name | set when |\n|---|---|---|\n";
  for (const RegisterBit& bit : bits)
    fmt::format_to(std::back_inserter(out), "| {} | `{}` | {} |\n", std::countr_zero(bit.mask), bit.name, bit.meaning);
}

/// CSV and JSON quote alike here: no text in the table holds a control character.
std::string quoted(std::string_view text, std::string_view quote_becomes) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"')
      out += quote_becomes;
    else
      out += c;
  }
  return out + "\"";
}

std::string json_bits(std::span<const RegisterBit> bits) {
  std::string out;
  for (const RegisterBit& bit : bits)
    fmt::format_to(std::back_inserter(out), "{}\n    {{\"bit\": {}, \"name\": \"{}\", \"meaning\": {}}}",
                   out.empty() ? "" : ",", std::countr_zero(bit.mask), bit.name, quoted(bit.meaning, "\\\""));
  return out;
}

std::string json_codes(std::span<const RegisterCode> codes) {
  std::string out;
  for (const RegisterCode& code : codes)
    fmt::format_to(std::back_inserter(out), "{}\n    {{\"code\": {}, \"meaning\": {}}}", out.empty() ? "" : ",",
                   code.code, quoted(code.meaning, "\\\""));
  return out;
}

std::string json_metrics() {
  std::string out;
  for (const Metric& metric : kMetrics)
    fmt::format_to(
        std::back_inserter(out),
        "{}\n    {{\"name\": \"{}\", \"kind\": \"{}\", \"unit\": \"{}\", \"counted\": \"{}\", \"meaning\": {}}}",
        out.empty() ? "" : ",", metric.name, kind_name(metric.kind), metric.unit, metric.counted,
        quoted(metric.meaning, "\\\""));
  return out;
}

}  // namespace

std::string register_map_markdown() {
  std::string out(kMarkdownHead);
  out += "| address | name | type | step | range (steps) | access | meaning |\n|---|---|---|---|---|---|---|\n";
  for (const RegisterEntry& entry : kRegisterMap)
    fmt::format_to(std::back_inserter(out), "| {} | `{}` | {} | {} | {} | {} | {} |\n", address_text(entry), entry.name,
                   type_name(entry.type), step_text(entry), range_text(entry), access_name(entry.access),
                   entry.meaning);
  out += "\n### Status bits (register 4)\n";
  append_bits(out, kStatusBits);
  out += "\n### Health flags (register 78)\n";
  append_bits(out, kHealthBits);
  out += "\n### Metrics (registers 60-79, 86-99, 108-117, 159-163)\n";
  append_metrics(out);
  out += "\n### Reason codes (register 5)\n";
  append_codes(out, kReasonCodes);
  out += "\n### What the pose registers carry (register 125)\n";
  append_codes(out, kPoseContentCodes);
  out += "\n### Angles 1, 2, 3 (register 126)\n";
  append_codes(out, kEulerCodes);
  out += "\n### What the head is doing (register 146)\n";
  append_codes(out, kHeadStateCodes);
  out += "\n### Commands (register 100)\n";
  append_codes(out, kCommandCodes);
  out += kMarkdownTail;
  return out;
}

std::string register_map_csv() {
  std::string out = "address,name,words,type,step,unit,lowest,highest,access,meaning\n";
  for (const RegisterEntry& entry : kRegisterMap)
    fmt::format_to(std::back_inserter(out), "{},{},{},{},{},{},{},{},{},{}\n", entry.address, entry.name, entry.words(),
                   type_name(entry.type), entry.scale, entry.unit, entry.lowest, entry.highest,
                   access_name(entry.access), quoted(entry.meaning, "\"\""));
  return out;
}

std::string register_map_json() {
  std::string registers;
  for (const RegisterEntry& entry : kRegisterMap)
    fmt::format_to(std::back_inserter(registers),
                   "{}\n    {{\"address\": {}, \"name\": \"{}\", \"words\": {}, \"type\": \"{}\", \"step\": {}, "
                   "\"step_is_configured\": {}, \"unit\": \"{}\", \"lowest\": {}, \"highest\": {}, \"access\": \"{}\", "
                   "\"meaning\": {}}}",
                   registers.empty() ? "" : ",", entry.address, entry.name, entry.words(), type_name(entry.type),
                   entry.scale, entry.scale_is_configured, entry.unit, entry.lowest, entry.highest,
                   access_name(entry.access), quoted(entry.meaning, "\\\""));
  return fmt::format(
      "{{\n  \"version\": {},\n  \"registers\": [{}\n  ],\n  \"status_bits\": [{}\n  ],\n  \"health_bits\": [{}\n  ],\n"
      "  \"metrics\": [{}\n  ],\n  \"reasons\": [{}\n  ],\n  \"pose_contents\": [{}\n  ],\n  \"euler_conventions\": "
      "[{}\n  ],\n"
      "  \"commands\": [{}\n  ],\n  \"head_states\": [{}\n  ]\n}}\n",
      kRegisterMapVersion, registers, json_bits(kStatusBits), json_bits(kHealthBits), json_metrics(),
      json_codes(kReasonCodes), json_codes(kPoseContentCodes), json_codes(kEulerCodes), json_codes(kCommandCodes),
      json_codes(kHeadStateCodes));
}

}  // namespace ninedot
