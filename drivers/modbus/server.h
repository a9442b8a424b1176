#pragma once
/// The Modbus side of the service: TCP, RTU or both, from one source.
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "drivers/modbus/command.h"
#include "drivers/modbus/counters.h"
#include "drivers/modbus/options.h"
#include "drivers/modbus/register_bank.h"
#include "drivers/modbus/rtu_server.h"
#include "drivers/modbus/tcp_server.h"
#include "proto/wire_report.h"

namespace ninedot {

/// Serves from construction to destruction, in a thread of its own per transport. Threads: see each method; ordinary
/// ones all, never the frame loop's.
class ModbusServer {
 public:
  /// Throws StartupError where an address can't be used or a setting is of no serial line; see TcpServer and RtuServer.
  /// \param source  must outlive the servers
  ModbusServer(const WireSource& source, const ModbusOptions& options);

  /// The port that TCP listens on, 0 without TCP. Threads: any.
  std::uint16_t tcp_port() const noexcept { return tcp_ ? tcp_->port() : 0; }

  /// Who is connected now; a serial line that has brought a request counts as a client. Allocates, may wait for the
  /// TCP server's lock. Threads: any.
  std::vector<ConnectedClient> clients() const;
  /// Threads: any; waits for nobody.
  ModbusCounters counters() const noexcept;
  /// The map as a client that asks now and holds nothing reads it. \return  raw words by address [1]. Threads: any.
  RegisterBlock registers() noexcept;
  /// See RtuServer::problem; empty without a serial line, too. Threads: any.
  std::string serial_problem() const { return rtu_ ? rtu_->problem() : std::string(); }
  /// See TcpServer::last_refusal. Threads: any.
  std::string last_refusal() const { return tcp_ ? tcp_->last_refusal() : std::string(); }

  /// What a client asks for, at most one thing at a time. Threads: one, whoever carries commands out.
  std::optional<ClientCommand> try_take_command() noexcept { return bank_.try_take_command(); }
  /// To be told for each command taken, unless it is from a watchdog. Threads: any.
  void finish_command(std::uint16_t sequence, bool succeeded) noexcept { bank_.finish_command(sequence, succeeded); }

 private:
  RegisterBank bank_;
  std::optional<TcpServer> tcp_;
  std::optional<RtuServer> rtu_;
};

}  // namespace ninedot
