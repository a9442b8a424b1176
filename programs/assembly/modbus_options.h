#pragma once
/// From the configuration to the Modbus servers, and to the command line that reads them.
#include <string>
#include <vector>

#include "config/config.h"
#include "drivers/modbus/options.h"

namespace ninedot {

ModbusOptions modbus_options(const Config& config);

/// [outputs]
PoseOutput pose_output(const Config& config);

/// How to read the position with the stock client `mbpoll`: a command line for each server, ready to copy.
std::vector<std::string> reading_commands(const ModbusOptions& options);

}  // namespace ninedot
