/// Reads copy the newest report out of its mailbox once and encode the whole map from that copy. Writes are checked
/// completely before the first one takes effect.
#include "drivers/modbus/register_bank.h"

#include <bit>
#include <numbers>

#include "base/units.h"
#include "proto/register_map.h"

namespace ninedot {
namespace {

constexpr std::chrono::seconds kSerialClientCounts{5};

bool is_in_range(const RegisterEntry& entry, std::uint16_t value) noexcept {
  const std::int64_t steps =
      entry.type == RegisterType::kI16 ? std::int64_t{std::bit_cast<std::int16_t>(value)} : std::int64_t{value};
  return steps >= entry.lowest && steps <= entry.highest;
}

double decode_one(std::uint16_t address, std::uint16_t value) noexcept {
  return decode_value(*find_register(address), std::span(&value, 1), {});
}

// What all clients share.
bool touches_commands(std::uint16_t first, std::size_t count) noexcept {
  const auto contains = [&](std::uint16_t address) { return first <= address && address < first + count; };
  return contains(reg::kCommand) || contains(reg::kCommandSequence) || contains(reg::kPanSetPoint) ||
         contains(reg::kTiltSetPoint);
}

}  // namespace

RegisterBank::RegisterBank(const WireSource& source, const ModbusOptions& options, Clock clock) noexcept
    : source_(source), options_(options), clock_(clock) {}

std::uint32_t RegisterBank::connected_clients(MonoTime now) const noexcept {
  const std::int64_t heard_ns = counters.serial_heard_ns.load(std::memory_order_relaxed);
  const bool serial = heard_ns != 0 && now - mono_from_ns(heard_ns) < kSerialClientCounts;
  return counters.tcp_clients.load(std::memory_order_relaxed) + (serial ? 1U : 0U);
}

void RegisterBank::add_own_metrics(MonoTime now, MetricValues& metrics) const noexcept {
  const auto count = [](const std::atomic<std::uint64_t>& counter) {
    return static_cast<double>(counter.load(std::memory_order_relaxed));
  };
  metrics[MetricId::kSerialOpen] = counters.serial_open.load(std::memory_order_acquire) ? 1 : 0;
  metrics[MetricId::kConnectedClients] = connected_clients(now);
  metrics[MetricId::kBusErrors] = count(counters.bus_errors);
  metrics[MetricId::kExceptions] = count(counters.exceptions);
  metrics[MetricId::kRequests] = count(counters.requests);
  metrics[MetricId::kConnections] = count(counters.connections);
  metrics[MetricId::kConnectionsRefused] = count(counters.connections_refused);
  metrics[MetricId::kConnectionsExpired] = count(counters.connections_expired);
  metrics[MetricId::kForeignFrames] = count(counters.foreign_frames);
  metrics[MetricId::kSerialLosses] = count(counters.serial_losses);
}

void RegisterBank::release_expired_hold(ClientSession& session) const noexcept {
  if (session.held && clock_() >= session.held_until) session.held.reset();
}

RegisterBlock RegisterBank::read(ClientSession& session) noexcept {
  release_expired_hold(session);
  WireState newest = source_.read(clock_());
  ServerState state;
  {
    const std::lock_guard lock(mutex_);
    state.commands = commands_;
    session.seen_writes = writes_;
  }
  state.commands.hold = session.held.has_value();
  state.commands.client_watchdog = session.watchdog;
  state.commands.give_way = session.gives_way;
  state.writes_enabled = options_.allow_writes;
  state.identity = options_.identity;
  state.now = clock_();  // after the report was taken, so that no age is negative
  add_own_metrics(state.now, newest.metrics);
  return encode_registers(session.held ? *session.held : newest.report, newest.metrics, state, options_.codec);
}

std::optional<ModbusException> RegisterBank::write(ClientSession& session, std::uint16_t first,
                                                   std::span<const std::uint16_t> values) noexcept {
  for (std::size_t i = 0; i < values.size(); ++i) {
    const std::size_t address = first + i;
    const RegisterEntry* entry =
        address < kRegisterCount ? find_register(static_cast<std::uint16_t>(address)) : nullptr;
    if (entry == nullptr || entry->access != RegisterAccess::kReadWrite) return ModbusException::kIllegalAddress;
    if (!is_in_range(*entry, values[i])) return ModbusException::kIllegalValue;
  }
  const std::lock_guard lock(mutex_);
  if (const auto refusal = refusal_of_command(session, first, values)) return refusal;
  if (touches_commands(first, values.size())) {
    // What it had not read before, it has not read now.
    if (session.seen_writes == writes_) ++session.seen_writes;
    ++writes_;
  }
  // The sequence number last: it starts the command, with the set-points of the same request.
  constexpr std::uint16_t kStart = reg::kCommandSequence;
  for (std::size_t i = 0; i < values.size(); ++i)
    if (first + i != kStart) apply(session, static_cast<std::uint16_t>(first + i), values[i]);
  if (first <= kStart && kStart < first + values.size()) apply(session, kStart, values[kStart - first]);
  return std::nullopt;
}

std::optional<ModbusException> RegisterBank::refusal_of_command(const ClientSession& session, std::uint16_t first,
                                                                std::span<const std::uint16_t> values) const noexcept {
  const bool is_overtaken = session.gives_way && session.seen_writes != writes_;
  if (is_overtaken && touches_commands(first, values.size())) return ModbusException::kDeviceBusy;
  const auto written = [&](std::uint16_t address, std::uint16_t otherwise) {
    return first <= address && address < first + values.size() ? values[address - first] : otherwise;
  };
  const std::uint16_t command = written(reg::kCommand, commands_.command);
  if (command > kLastCommand) return ModbusException::kIllegalValue;
  if (written(reg::kCommandSequence, commands_.sequence) == commands_.sequence) return std::nullopt;
  if (command != 0 && !supports(static_cast<Command>(command))) return ModbusException::kDeviceFailure;
  return std::nullopt;
}

void RegisterBank::apply(ClientSession& session, std::uint16_t address, std::uint16_t value) noexcept {
  switch (address) {
    case reg::kCommand:
      commands_.command = value;
      break;
    case reg::kCommandSequence:
      if (value == commands_.sequence) break;
      commands_.sequence = value;
      if (commands_.command == 0) {
        commands_.acknowledge = value;
        commands_.result = CommandResult::kDone;
        break;
      }
      commands_.result = CommandResult::kRunning;
      waiting_command_ =
          ClientCommand{static_cast<Command>(commands_.command), value, commands_.pan_set_point_deg * kRadPerDeg,
                        commands_.tilt_set_point_deg * kRadPerDeg, false};
      break;
    case reg::kHold:
      session.held.reset();
      if (value != 0) {
        session.held = source_.read(clock_()).report;
        session.held_until = clock_() + options_.hold_time;
      }
      break;
    case reg::kPanSetPoint:
      commands_.pan_set_point_deg = decode_one(address, value);
      break;
    case reg::kTiltSetPoint:
      commands_.tilt_set_point_deg = decode_one(address, value);
      break;
    case reg::kClientWatchdog:
      session.watchdog = std::chrono::milliseconds(value);
      break;
    case reg::kGiveWay:
      session.gives_way = value != 0;
      break;
    default:
      EXPECTS(false && "a writable register without a meaning");
  }
}

void RegisterBank::request_arrived(ClientSession& session) noexcept {
  counters.requests.fetch_add(1, std::memory_order_relaxed);
  // A request that comes too late must not hide that the client had been silent for too long.
  (void)check_watchdog(session);
  session.last_request_at = clock_();
}

std::optional<MonoTime> RegisterBank::check_watchdog(ClientSession& session) noexcept {
  if (session.watchdog.count() == 0) return std::nullopt;
  const MonoTime due = session.last_request_at + session.watchdog;
  if (clock_() < due) return due;
  fire_watchdog(session);
  return std::nullopt;
}

void RegisterBank::client_left(ClientSession& session) noexcept {
  session.gives_way = false;
  if (session.watchdog.count() != 0) fire_watchdog(session);
}

void RegisterBank::fire_watchdog(ClientSession& session) noexcept {
  session.watchdog = {};
  const std::lock_guard lock(mutex_);
  if (supports(Command::kFollow)) follow_waiting_ = true;
}

std::optional<ClientCommand> RegisterBank::try_take_command() noexcept {
  const std::lock_guard lock(mutex_);
  // A command waiting beside the event is taken first, so that the safe state has the last word.
  if (waiting_command_) {
    const ClientCommand command = *waiting_command_;
    waiting_command_.reset();
    return command;
  }
  if (!follow_waiting_) return std::nullopt;
  follow_waiting_ = false;
  ClientCommand command;
  command.command = Command::kFollow;
  command.from_watchdog = true;
  return command;
}

void RegisterBank::finish_command(std::uint16_t sequence, bool succeeded) noexcept {
  const std::lock_guard lock(mutex_);
  if (commands_.result != CommandResult::kRunning || commands_.sequence != sequence) return;
  commands_.acknowledge = sequence;
  commands_.result = succeeded ? CommandResult::kDone : CommandResult::kFailed;
}

}  // namespace ninedot
