#include "programs/service/service_watch.h"

#include <fmt/format.h>

#include <cstring>
#include <optional>

#include "drivers/posix/board_temperature.h"
#include "drivers/posix/service_manager.h"
#include "programs/display/live_display.h"
#include "programs/display/status_view.h"
#include "programs/service/status_led.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

// What a client's command waits for at most.
constexpr auto kPeriod = 20ms;

/// The registers as a client that asks now would read them.
RegisterBlock registers_now(const RunningService& service, std::uint32_t clients, MonoTime now) {
  const ModbusCounters counters = service.modbus.counters();
  ServerState server;
  server.now = now;
  server.connected_clients = clients;
  server.bus_errors = counters.bus_errors;
  server.exceptions = counters.exceptions;
  return encode_registers(service.reports.read(), service.health.read(), server, service.codec);
}

void show(LiveDisplay& display, const RunningService& service, MonoTime now) {
  std::vector<std::string> lines;
  for (const ConnectedClient& client : service.modbus.clients())
    lines.push_back(fmt::format("{}, {} requests", client.address, client.requests));
  const RegisterBlock registers = registers_now(service, static_cast<std::uint32_t>(lines.size()), now);
  display.show(RegisterReader(registers, service.codec), lines, now);
}

void carry_out_commands(ModbusServer& modbus, HeadControl& head) {
  while (const std::optional<ClientCommand> command = modbus.try_take_command()) {
    head.order({command->command == Command::kFollow, {command->pan_rad, command->tilt_rad}});
    if (!command->from_watchdog) modbus.finish_command(command->sequence, true);
  }
}

void note_devices(const RunningService& service, ServiceLog& log, MonoTime now) {
  for (const WatchedDevice& device : service.devices)
    log.note_device(device.name, device.problem(), device.description ? device.description() : "", now);
}

void note_modbus(const ModbusServer& modbus, ServiceLog& log, MonoTime now) {
  const ModbusCounters counters = modbus.counters();
  log.note_device("Modbus RTU", modbus.serial_problem(), "", now);
  log.note_series("unreadable Modbus frames", counters.unreadable_frames, "", now);
  log.note_series("Modbus clients refused", counters.refused_connections, modbus.last_refusal(), now);
}

}  // namespace

void watch_until_signalled(const TerminationSignals& signals, const RunningService& service, ServiceLog& log,
                           LiveDisplay* display) {
  ServiceManager manager;
  MonoTime measured_at{};
  while (signals.wait(kPeriod) == 0) {
    const MonoTime now = mono_now();
    const Report report = service.reports.read();
    log.note(report, service.frames.last_error(), now);
    if (service.head != nullptr) carry_out_commands(service.modbus, *service.head);
    // A line that can't be driven is no reason to stop: the log tells it, and it is opened again.
    if (service.status_led != nullptr)
      static_cast<void>(service.status_led->set(is_led_lit(led_pattern_of(report), now)));
    if (service.lone_power != nullptr) static_cast<void>(service.lone_power->set(true));
    note_devices(service, log, now);
    note_modbus(service.modbus, log, now);
    // Without its camera the service is up as well: it answers, says so, and recovers by itself.
    if (service.frames.frames_processed() > 0 || report.reason == Reason::kCameraLost) manager.ready();
    // A source that is over ends on purpose: from then on time itself counts as progress.
    manager.feed_watchdog(service.frames.over() ? static_cast<std::uint64_t>(to_ns(now)) : service.frames.turns(), now);
    if (now - measured_at >= 1s) {
      measured_at = now;
      service.frames.set_temperature(read_board_temperature());
    }
    if (display != nullptr) show(*display, service, now);
  }
  manager.stopping();
}

std::string realtime_text(int priority, int refused_errno) {
  if (refused_errno == 0) return fmt::format("SCHED_FIFO {}", priority);
  if (priority == 0) return "ordinary priority, as configured";
  return fmt::format("ordinary priority: SCHED_FIFO {} was refused ({}): allow it with LimitRTPRIO= or `ulimit -r`",
                     priority, std::strerror(refused_errno));
}

std::string memory_text(bool wanted, const Result<void>& locked) {
  if (!wanted) return "not locked, as configured";
  if (locked) return "locked";
  return fmt::format("not locked ({}): allow it with LimitMEMLOCK= or `ulimit -l`",
                     std::strerror(locked.error().os_errno));
}

}  // namespace ninedot
