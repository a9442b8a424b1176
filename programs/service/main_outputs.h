#pragma once
/// The outputs that the main thread drives: log, live display, status LED, and the commands of Modbus clients on their
/// way to the head. Each keeps references that must outlive it. Threads: the main thread alone.
#include <span>

#include "drivers/modbus/server.h"
#include "outputs/head_output.h"
#include "pipeline/frame_loop.h"
#include "ports/digital_io.h"
#include "programs/assembly/watched_device.h"
#include "programs/display/live_display.h"
#include "programs/service/command_desk.h"
#include "programs/service/service_log.h"

namespace ninedot {

/// What changed, as lines on standard error.
class LogOutput final : public Output {
 public:
  LogOutput(ServiceLog& log, const FrameLoop& frames) noexcept : log_(log), frames_(frames) {}
  void take(const Report& newest, bool is_new, MonoTime now) override;

 private:
  ServiceLog& log_;
  const FrameLoop& frames_;
};

/// What becomes of the devices and of the Modbus lines, as lines on standard error.
class DeviceLogOutput final : public Output {
 public:
  DeviceLogOutput(ServiceLog& log, std::span<const WatchedDevice> devices, const ModbusServer& modbus) noexcept
      : log_(log), devices_(devices), modbus_(modbus) {}
  void take(const Report& newest, bool is_new, MonoTime now) override;

 private:
  ServiceLog& log_;
  const std::span<const WatchedDevice> devices_;
  const ModbusServer& modbus_;
};

/// What a Modbus client would read now, for the person who started the service with --live.
class LiveOutput final : public Output {
 public:
  LiveOutput(LiveDisplay& display, ModbusServer& modbus, const RegisterCodecOptions& codec) noexcept
      : display_(display), modbus_(modbus), codec_(codec) {}
  void take(const Report& newest, bool is_new, MonoTime now) override;

 private:
  LiveDisplay& display_;
  ModbusServer& modbus_;
  const RegisterCodecOptions codec_;
};

class LedOutput final : public Output {
 public:
  explicit LedOutput(DigitalOutput& led) noexcept : led_(led) {}
  void take(const Report& newest, bool is_new, MonoTime now) override;

 private:
  DigitalOutput& led_;
};

/// Servo power without a head: kept on, and set again when its line comes back.
class PowerOutput final : public Output {
 public:
  explicit PowerOutput(DigitalOutput& power) noexcept : power_(power) {}
  void take(const Report& newest, bool is_new, MonoTime now) override;

 private:
  DigitalOutput& power_;
};

/// Clients' commands become orders to the head, and what the reports say of the orders becomes their result.
class CommandOutput final : public Output {
 public:
  CommandOutput(ModbusServer& modbus, HeadOutput& head) noexcept : modbus_(modbus), head_(head) {}
  void take(const Report& newest, bool is_new, MonoTime now) override;

 private:
  ModbusServer& modbus_;
  HeadOutput& head_;
  CommandDesk desk_;
};

}  // namespace ninedot
