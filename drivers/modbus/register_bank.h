#pragma once
/// What all Modbus clients share: the newest report as registers, the commands they write, and the counters.
#include <atomic>
#include <chrono>
#include <cstdint>
#include <mutex>
#include <optional>
#include <span>

#include "base/mono_time.h"
#include "drivers/modbus/command.h"
#include "drivers/modbus/options.h"
#include "proto/register_codec.h"
#include "proto/wire_report.h"

namespace ninedot {

/// Codes of the Modbus Application Protocol 1.1b3, section 7, that this server sends.
enum class ModbusException : std::uint8_t {
  kIllegalFunction = 1,
  kIllegalAddress = 2,
  kIllegalValue = 3,
  kDeviceFailure = 4,
  kDeviceBusy = 6,
};

/// What belongs to one client: a TCP connection, or the serial line. Threads: one, that of its server.
struct ClientSession {
  std::optional<WireReport> held;  ///< the report that HOLD froze
  MonoTime held_until{};
  std::chrono::milliseconds watchdog{};  ///< 0: off
  MonoTime last_request_at{};
  bool gives_way = false;
  std::uint64_t seen_writes = 0;  ///< of RegisterBank's count: those up to here it has read, or written itself
};

/// What each one means: proto/metrics.h. Threads: the servers' count, any reads; each one is right by itself, and two
/// of them need not be of the same moment, but that whoever first sees the serial line closed finds its loss counted.
struct BankCounters {
  std::atomic<std::uint64_t> requests{0}, exceptions{0}, bus_errors{0};
  std::atomic<std::uint64_t> connections{0}, connections_refused{0}, connections_expired{0};
  std::atomic<std::uint64_t> foreign_frames{0}, serial_losses{0};
  std::atomic<std::uint64_t> unreadable_frames{0};  ///< of the bus errors: broken frames and check sums
  std::atomic<bool> serial_open{false};
  std::atomic<std::uint32_t> tcp_clients{0};
  std::atomic<std::int64_t> serial_heard_ns{0};  ///< when the serial line last brought a request for us; 0 = never
};

/// Threads: see each method; ordinary ones all, never the frame loop's. Where a method waits for a lock, nobody holds
/// it for longer than it takes to copy a few words or one report. One session belongs to one thread at a time, several
/// sessions may be served at once.
class RegisterBank {
 public:
  using Clock = MonoTime (*)() noexcept;

  /// \param source  must outlive the bank \param clock  for tests
  RegisterBank(const WireSource& source, const ModbusOptions& options, Clock clock = mono_now) noexcept;

  /// The whole map for one reply, all of it from one report. \return  raw words by address [1]
  /// Threads: any, each with a session of its own; may wait for the lock.
  RegisterBlock read(ClientSession& session) noexcept;

  /// Writes consecutive registers, all of them or none. \return  nothing, or the exception that answers
  /// Threads: as `read`.
  std::optional<ModbusException> write(ClientSession& session, std::uint16_t first,
                                       std::span<const std::uint16_t> values) noexcept;

  /// To be called for each complete request, before it is answered. Threads: as `read`.
  void request_arrived(ClientSession& session) noexcept;
  /// Fires the session's watchdog if its time is over. \return  when to call again, nothing while it is off
  /// Threads: as `read`.
  std::optional<MonoTime> check_watchdog(ClientSession& session) noexcept;
  /// The client is gone; an armed watchdog fires, and whoever comes next does not give way. Threads: as `read`.
  void client_left(ClientSession& session) noexcept;

  /// The newest one not yet taken; what it took the place of is forgotten.
  /// Threads: one, whoever carries commands out; may wait for the lock.
  std::optional<ClientCommand> try_take_command() noexcept;
  /// No effect where a newer command has taken its place. Threads: any; may wait for the lock.
  void finish_command(std::uint16_t sequence, bool succeeded) noexcept;

  /// Threads: any, both.
  bool writes_enabled() const noexcept { return options_.allow_writes; }
  MonoTime now() const noexcept { return clock_(); }

  BankCounters counters;

 private:
  bool supports(Command command) const noexcept {
    return (options_.supported_commands >> static_cast<unsigned>(command) & 1U) != 0;
  }
  void fire_watchdog(ClientSession& session) noexcept;
  void release_expired_hold(ClientSession& session) const noexcept;
  void apply(ClientSession& session, std::uint16_t address, std::uint16_t value) noexcept;
  std::optional<ModbusException> refusal_of_command(const ClientSession& session, std::uint16_t first,
                                                    std::span<const std::uint16_t> values) const noexcept;
  std::uint32_t connected_clients(MonoTime now) const noexcept;
  void add_own_metrics(MonoTime now, MetricValues& metrics) const noexcept;

  const WireSource& source_;
  const ModbusOptions options_;
  const Clock clock_;

  std::mutex mutex_;  // guards what follows
  CommandRegisters commands_;
  std::uint64_t writes_ = 0;  // of commands and set-points, whoever's
  std::optional<ClientCommand> waiting_command_;
  bool follow_waiting_ = false;
};

}  // namespace ninedot
