#include "drivers/modbus/server.h"

namespace ninedot {

ModbusServer::ModbusServer(const Mailbox<Report>& reports, const Mailbox<Health>& health,
                           const ModbusOptions& options)
    : bank_(reports, health, options) {
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
  ModbusCounters counters;
  counters.requests = bank_.counters.requests.load(std::memory_order_relaxed);
  counters.exceptions = bank_.counters.exceptions.load(std::memory_order_relaxed);
  counters.bus_errors = bank_.counters.bus_errors.load(std::memory_order_relaxed);
  if (tcp_) tcp_->add_to(counters);
  if (rtu_) rtu_->add_to(counters);
  return counters;
}

}  // namespace ninedot
