#pragma once
/// Modbus RTU: one thread on one serial line, which may come late, vanish and come back.
#include <modbus/modbus.h>

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "drivers/modbus/counters.h"
#include "drivers/modbus/options.h"
#include "drivers/modbus/register_bank.h"
#include "drivers/modbus/rtu_receiver.h"
#include "drivers/posix/file_descriptor.h"
#include "drivers/posix/late_device.h"

namespace ninedot {

/// Serves from construction to destruction. libmodbus opens and sets up the line; its receiving side waits without a
/// limit and is not used. The bank must outlive it.
class RtuServer {
 public:
  /// A line that is not there, in use, or not permitted is opened when it can be.
  /// Throws StartupError(kWrongUsage) naming the device, for settings that no line has and for what is no serial line.
  RtuServer(RegisterBank& bank, const ModbusRtuOptions& options);
  ~RtuServer();
  RtuServer(const RtuServer&) = delete;
  RtuServer& operator=(const RtuServer&) = delete;

  /// Allocates; waits for nobody. Threads: any.
  void append_clients(std::vector<ConnectedClient>& clients) const;
  /// Why the line is not open; empty: it is. Allocates, may wait for the thread that opens. Threads: any.
  std::string problem() const { return problem_.read(); }

 private:
  struct CloseLine {
    void operator()(modbus_t* line) const noexcept;
  };
  using Line = std::unique_ptr<modbus_t, CloseLine>;
  enum class LineState : std::uint8_t { kGood, kLost, kStopping };

  static Line open_line(const ModbusRtuOptions& options) noexcept;
  void take_over_line() noexcept;
  void note_absent(int error);
  void run() noexcept;
  LineState serve_until_lost() noexcept;
  LineState wait_for_bytes(MonoTime wake_at, bool& arrived) noexcept;
  LineState receive() noexcept;
  LineState answer(const RtuRequest& request) noexcept;
  LineState send(std::span<const std::uint8_t> frame) noexcept;
  bool reopen() noexcept;
  bool is_own_echo(std::span<const std::uint8_t> frame) const noexcept;
  void publish_counts() noexcept;

  RegisterBank& bank_;
  const ModbusRtuOptions options_;
  const std::chrono::nanoseconds character_time_;
  const std::chrono::nanoseconds frame_silence_;
  Line line_;
  int fd_ = -1;  // belongs to line_
  DeviceNote problem_;
  WakeUp stop_;

  RtuReceiver receiver_;
  ClientSession session_;
  std::array<std::uint8_t, kMaxRtuFrame> sent_{};
  std::size_t sent_size_ = 0;
  MonoTime echo_until_{};

  std::uint64_t counted_broken_ = 0;
  std::atomic<std::uint64_t> requests_{0};
  const MonoTime started_at_;
  std::thread thread_;
};

/// What RtuServer would refuse or wait for, as far as can be seen without opening the line, which a running service may
/// be using. Throws DeviceAbsent: it is not there, or not permitted; StartupError(kWrongUsage) as RtuServer.
void check_rtu_line(const ModbusRtuOptions& options);

}  // namespace ninedot
