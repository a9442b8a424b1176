#include "programs/assembly/modbus_options.h"

#include <fmt/format.h>

#include <cmath>

#include "proto/register_map.h"

namespace ninedot {

ModbusOptions modbus_options(const Config& config) {
  ModbusOptions options;
  options.codec.position_step_mm = config.modbus.position_scale_16bit_mm;
  options.codec.float_word_order =
      config.modbus.float_word_order == "low-first" ? WordOrder::kLowFirst : WordOrder::kHighFirst;
  options.allow_writes = config.modbus.allow_writes;
  options.hold_time = std::chrono::milliseconds(config.modbus.hold_ms);
  if (config.pan_tilt.driver != "none")
    options.supported_commands = 1U << static_cast<unsigned>(Command::kFollow) |
                                 1U << static_cast<unsigned>(Command::kPoint) |
                                 1U << static_cast<unsigned>(Command::kPark);
  if (config.modbus_tcp.enabled) {
    const auto idle_ms = static_cast<std::int64_t>(std::lround(config.modbus_tcp.idle_timeout_s * 1000));
    options.tcp = ModbusTcpOptions{config.modbus_tcp.listen, config.modbus_tcp.port,
                                   static_cast<std::size_t>(config.modbus_tcp.max_clients),
                                   std::chrono::milliseconds(idle_ms), config.modbus_tcp.allow};
  }
  if (config.modbus_rtu.enabled) {
    options.rtu = ModbusRtuOptions{.device = config.modbus_rtu.device,
                                   .baud = config.modbus_rtu.baud,
                                   .parity = config.modbus_rtu.parity,
                                   .unit = static_cast<std::uint8_t>(config.modbus_rtu.unit)};
  }
  return options;
}

std::string address_from_here(const ModbusTcpConfig& config) {
  return config.listen == "0.0.0.0" ? "127.0.0.1" : config.listen == "::" ? "::1" : config.listen;
}

PoseOutput pose_output(const Config& config) {
  PoseOutput output;
  if (config.outputs.pose == "camera_in_landmark") output.content = PoseContent::kCameraInLandmark;
  if (config.outputs.pose == "body_in_world") output.content = PoseContent::kBodyInWorld;
  if (config.outputs.euler == "fanuc") output.euler = EulerConvention::kFanuc;
  if (config.outputs.euler == "kuka") output.euler = EulerConvention::kKuka;
  return output;
}

std::vector<std::string> reading_commands(const ModbusOptions& options) {
  // -0: addresses as on the wire; -B: high word first; -t 4:int: 32-bit integers in holding registers.
  const std::string registers = fmt::format("-0 -r {} -c 6 -t 4:int -B -1", reg::kX32);
  std::vector<std::string> commands;
  if (options.tcp) {
    const std::string& listen = options.tcp->listen;
    const bool everywhere = listen == "0.0.0.0" || listen == "::";
    commands.push_back(
        fmt::format("mbpoll -m tcp -p {} -a 1 {} {}", options.tcp->port, registers, everywhere ? "127.0.0.1" : listen));
  }
  if (options.rtu) {
    const char* parity = options.rtu->parity == 'E' ? "even" : options.rtu->parity == 'O' ? "odd" : "none";
    commands.push_back(fmt::format("mbpoll -m rtu -b {} -P {} -a {} {} DEVICE", options.rtu->baud, parity,
                                   options.rtu->unit, registers));
  }
  return commands;
}

}  // namespace ninedot
