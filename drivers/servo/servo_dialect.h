#pragma once
/// What makers of smart servos have in common, registers that are read and written over a half-duplex line, and what
/// each of them says in a way of its own: packets, addresses, numbers. No input or output.
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "base/inline_vector.h"

namespace ninedot {

/// Bytes of one packet, or of some registers; the longest here is a Dynamixel's answer of 42.
using ServoBytes = InlineVector<std::uint8_t, 64>;

/// Pan and tilt, as one packet for both.
struct ServoPart {
  int id = 0;
  std::span<const std::uint8_t> bytes;
};

/// What stands at the beginning of the bytes that were received.
struct PacketLook {
  enum class Kind : std::uint8_t {
    kNone,        ///< no packet begins here: the first byte is noise
    kIncomplete,  ///< one may begin here; more bytes will tell
    kWhole,       ///< a packet whose check sum is right
  };
  Kind kind = Kind::kNone;
  std::size_t size = 0;  ///< [bytes] of a whole one
};

struct ServoReply {
  int id = 0;
  bool alarm = false;  ///< the servo says that something is wrong with it
  ServoBytes bytes;    ///< of the registers that were read; empty: a write was heard
};

/// One servo's registers from ServoTable::state_address on.
struct ServoState {
  int goal = 0;      ///< [steps]
  int position = 0;  ///< [steps]
  double load_percent = 0;
  double supply_V = 0;  ///< [V]
  double temperature_degC = 0;
};

/// Where things stand in a servo's memory.
struct ServoTable {
  int torque_address = 0;              ///< 1 byte: 1 = under force
  int goal_address = 0;                ///< what `encode_goal` makes
  int state_address = 0;               ///< what `decode_state` reads
  int state_size = 0;                  ///< [bytes]
  int mode_address = 0;                ///< 1 byte, and one behind it that can be read; none: negative
  int position_mode = 0;               ///< what it must hold: the servo goes to positions
  int max_position = 0;                ///< [steps], from 0
  std::optional<int> speed_address{};  ///< where `encode_speed` belongs; none: a goal holds its speed
};

/// Every method: memory: none. Threads: pure; any.
class ServoDialect {
 public:
  virtual ~ServoDialect() = default;
  virtual const ServoTable& table() const noexcept = 0;

  virtual ServoBytes encode_read(int id, int address, int count) const noexcept = 0;
  virtual ServoBytes encode_write(const ServoPart& part, int address) const noexcept = 0;
  /// To both servos at once, which do not answer. \param pan, tilt  as many bytes each (contract)
  virtual ServoBytes encode_write_both(const ServoPart& pan, const ServoPart& tilt, int address) const noexcept = 0;
  /// Both servos answer, one after the other. None: they must be asked one by one.
  virtual std::optional<ServoBytes> encode_read_both(int pan_id, int tilt_id, int address,
                                                     int count) const noexcept = 0;

  virtual PacketLook look_at(std::span<const std::uint8_t> received) const noexcept = 0;
  /// \param packet  a whole one. \return  none: no servo's answer
  virtual std::optional<ServoReply> decode(std::span<const std::uint8_t> packet) const noexcept = 0;

  /// \param position  [steps], 0..max_position (contract)
  /// \param steps_per_s  [steps/s] how fast to go there
  virtual ServoBytes encode_goal(int position, double steps_per_s) const noexcept = 0;
  virtual ServoBytes encode_speed(double steps_per_s) const noexcept = 0;
  /// \param bytes  state_size of them (contract)
  virtual ServoState decode_state(std::span<const std::uint8_t> bytes) const noexcept = 0;
};

}  // namespace ninedot
