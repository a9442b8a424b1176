#pragma once
/// What the Modbus servers are told at their start. No configuration file in here: the application translates.
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "proto/register_codec.h"

namespace ninedot {

struct ModbusTcpOptions {
  std::string listen = "127.0.0.1";                                   ///< IPv4 or IPv6 address, numeric
  std::uint16_t port = 1502;                                          ///< 0: any free one, see ModbusServer::tcp_port
  std::size_t max_clients = 16;                                       ///< 1..64 (contract)
  std::chrono::milliseconds idle_timeout = std::chrono::seconds(60);  ///< without a complete request: closed
  std::vector<std::string> allow;  ///< addresses or address/prefix-length that may connect; empty = all
};

struct ModbusRtuOptions {
  std::string device = "/dev/ttyS1";
  int baud = 115200;
  char parity = 'E';      ///< N | E | O
  int stop_bits = 1;      ///< 1 | 2
  std::uint8_t unit = 1;  ///< 1..247 (contract)
};

struct ModbusOptions {
  RegisterCodecOptions codec;
  bool allow_writes = false;
  std::chrono::milliseconds hold_time{500};  ///< HOLD releases itself after this time
  DeviceIdentity identity;
  std::uint32_t supported_commands = 0;  ///< bit n: somebody carries out Command(n); without it: exception 04
  std::optional<ModbusTcpOptions> tcp;
  std::optional<ModbusRtuOptions> rtu;
};

}  // namespace ninedot
