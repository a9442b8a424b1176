#pragma once
/// Registers from a report, and values from registers, by the table of register_map.h.
///
/// Words are made by shifts and std::bit_cast, never by libmodbus's float functions: those changed their meaning
/// between versions. Values are rounded to the nearest step and saturate at the ends of their range; only counters
/// wrap. Not a number: -32768 or -2147483648 (signed), 65535 or the range's end (unsigned), a quiet NaN (float32).
/// Memory: none. Threads: pure.
#include <array>
#include <chrono>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "base/mono_time.h"
#include "proto/register_map.h"
#include "proto/wire_report.h"

namespace ninedot {

enum class WordOrder : std::uint8_t { kHighFirst, kLowFirst };

struct RegisterCodecOptions {
  double position_step_mm = 0.5;                       ///< one step of the 16-bit x y z, > 0 (contract)
  WordOrder float_word_order = WordOrder::kHighFirst;  ///< of float32 only; integers are high word first
  std::chrono::nanoseconds stale_after = std::chrono::milliseconds(500);  ///< older poses are stale, and not valid
};

/// Registers 100-107 and 167 as one client sees them.
struct CommandRegisters {
  std::uint16_t command = 0, sequence = 0;
  std::uint16_t acknowledge = 0;  ///< sequence number of the last command that has ended
  CommandResult result = CommandResult::kNone;
  bool hold = false;
  double pan_set_point_deg = 0, tilt_set_point_deg = 0;
  std::chrono::milliseconds client_watchdog{};
  bool give_way = false;
};

/// Who this device is: the same for as long as the service runs.
struct DeviceIdentity {
  std::array<std::uint16_t, 3> version{};               ///< of the software: major, minor, patch
  std::array<char, kBoardSerialLength> board_serial{};  ///< ASCII, zeros behind it; all zeros: the board tells none
};

/// What a reply needs beside the report.
struct ServerState {
  MonoTime now{};  ///< the moment of the reply: the age counts up to it
  bool writes_enabled = false;
  CommandRegisters commands;
  DeviceIdentity identity;
};

using RegisterBlock = std::array<std::uint16_t, kRegisterCount>;

/// The whole map for one reply, words by address. Unmapped addresses are 0.
RegisterBlock encode_registers(const WireReport& report, const MetricValues& metrics, const ServerState& server,
                               const RegisterCodecOptions& options) noexcept;

/// One value into its words. \param value  [unit of the entry]
void encode_value(const RegisterEntry& entry, double value, const RegisterCodecOptions& options,
                  std::span<std::uint16_t> words) noexcept;

/// One value from its words. \param words  entry.words() of them
/// \return  [unit of the entry]; NaN for the signed "unknown"
double decode_value(const RegisterEntry& entry, std::span<const std::uint16_t> words,
                    const RegisterCodecOptions& options) noexcept;

/// A client's view of the map: reads values by address from registers read before.
class RegisterReader {
 public:
  /// \param registers  the words from address 0 on; must outlive this reader
  explicit RegisterReader(std::span<const std::uint16_t> registers, const RegisterCodecOptions& options = {}) noexcept
      : registers_(registers), options_(options) {}

  /// \param address  of the first word of an entry that was read (contract) \return  [unit of the entry]
  double value(std::uint16_t address) const noexcept;
  std::uint32_t integer(std::uint16_t address) const noexcept;  ///< an unsigned entry or a counter, in steps
  bool status(std::uint16_t bit) const noexcept { return (integer(reg::kStatus) & bit) != 0; }

  std::string board_serial() const;  ///< as text; empty: the board tells none, or what it tells is no text

  /// The device is ours and speaks this map.
  bool is_ninedot() const noexcept {
    return integer(reg::kMagic) == kRegisterMapMagic && integer(reg::kMapVersion) == kRegisterMapVersion;
  }
  bool is_of_one_frame() const noexcept { return integer(reg::kPoseSequence) == integer(reg::kPoseSequenceCopy); }

 private:
  std::span<const std::uint16_t> registers_;
  RegisterCodecOptions options_;
};

}  // namespace ninedot
