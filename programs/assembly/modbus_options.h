#pragma once
/// From the configuration to the Modbus servers, and to the command line that reads them.
#include <string>
#include <vector>

#include "config/config.h"
#include "drivers/modbus/options.h"

namespace ninedot {

ModbusOptions modbus_options(const Config& config);

/// Where the service's Modbus TCP is reached from its own machine: a numeric address.
std::string address_from_here(const ModbusTcpConfig& config);

/// [outputs]
PoseOutput pose_output(const Config& config);

/// How to read the position with the stock client `mbpoll`: a command line for each server, ready to copy.
std::vector<std::string> reading_commands(const ModbusOptions& options);

}  // namespace ninedot
