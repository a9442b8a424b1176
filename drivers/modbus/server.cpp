#include "drivers/modbus/server.h"

namespace ninedot {

ModbusServer::ModbusServer(const WireSource& source, const ModbusOptions& options) : bank_(source, options) {
  if (options.tcp) tcp_.emplace(bank_, *options.tcp);
  if (options.rtu) rtu_.emplace(bank_, *options.rtu);
}

std::vector<ConnectedClient> ModbusServer::clients() const {
  std::vector<ConnectedClient> clients;
  if (tcp_) tcp_->append_clients(clients);
  if (rtu_) rtu_->append_clients(clients);
  return clients;
}

ModbusCounters ModbusServer::counters() const noexcept {
  const BankCounters& from = bank_.counters;
  ModbusCounters counters;
  counters.serial_open = from.serial_open.load(std::memory_order_acquire);
  counters.requests = from.requests.load(std::memory_order_relaxed);
  counters.exceptions = from.exceptions.load(std::memory_order_relaxed);
  counters.bus_errors = from.bus_errors.load(std::memory_order_relaxed);
  counters.connections = from.connections.load(std::memory_order_relaxed);
  counters.refused_connections = from.connections_refused.load(std::memory_order_relaxed);
  counters.expired_connections = from.connections_expired.load(std::memory_order_relaxed);
  counters.unreadable_frames = from.unreadable_frames.load(std::memory_order_relaxed);
  counters.foreign_frames = from.foreign_frames.load(std::memory_order_relaxed);
  counters.serial_losses = from.serial_losses.load(std::memory_order_relaxed);
  return counters;
}

RegisterBlock ModbusServer::registers() noexcept {
  ClientSession nobody;
  return bank_.read(nobody);
}

}  // namespace ninedot
