#include "programs/service/main_outputs.h"

#include <fmt/format.h>

#include <optional>
#include <string>
#include <vector>

#include "programs/service/status_led.h"

namespace ninedot {

void LogOutput::take(const Report& newest, bool is_new, MonoTime now) {
  log_.note(newest, frames_.last_error(), now);
  log_.note_row_time(newest.row_time);
  if (is_new) log_.note_misplaced(newest, now);
}

void DeviceLogOutput::take(const Report& /*newest*/, bool /*is_new*/, MonoTime now) {
  for (const WatchedDevice& device : devices_)
    log_.note_device(device.name, device.problem(), device.description ? device.description() : "", now);
  const ModbusCounters counters = modbus_.counters();
  log_.note_device("Modbus RTU", modbus_.serial_problem(), "", now);
  log_.note_series("unreadable Modbus frames", counters.unreadable_frames, "", now);
  log_.note_series("Modbus clients refused", counters.refused_connections, modbus_.last_refusal(), now);
}

void LiveOutput::take(const Report& /*newest*/, bool /*is_new*/, MonoTime now) {
  if (!display_.is_due(now)) return;
  std::vector<std::string> lines;
  for (const ConnectedClient& client : modbus_.clients())
    lines.push_back(fmt::format("{}, {} request{}", client.address, client.requests, client.requests == 1 ? "" : "s"));
  const RegisterBlock registers = modbus_.registers();
  display_.show(RegisterReader(registers, codec_), lines, now);
}

void LedOutput::take(const Report& newest, bool /*is_new*/, MonoTime now) {
  // A LED that can't be driven is no reason to stop: the log tells it, and its line is opened again.
  static_cast<void>(led_.set(is_led_lit(led_pattern_of(newest), now)));
}

void PowerOutput::take(const Report& /*newest*/, bool /*is_new*/, MonoTime /*now*/) {
  static_cast<void>(power_.set(true));
}

void CommandOutput::take(const Report& newest, bool /*is_new*/, MonoTime /*now*/) {
  while (const std::optional<ClientCommand> command = modbus_.try_take_command()) {
    if (const auto ended = desk_.end_for_watchdog(*command)) modbus_.finish_command(ended->sequence, ended->succeeded);
    head_.order(desk_.accept(*command));
  }
  if (const auto ended = desk_.end_by(newest.head)) modbus_.finish_command(ended->sequence, ended->succeeded);
}

}  // namespace ninedot
