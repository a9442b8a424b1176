#pragma once
/// The service's hands on the tap: what the frame loop shows it, and what the main thread tells of clients and log.
#include <array>
#include <string>

#include "drivers/modbus/server.h"
#include "drivers/tap/tap_writer.h"
#include "outputs/output.h"
#include "pipeline/frame_loop.h"
#include "pipeline/frame_observer.h"
#include "programs/service/service_log.h"

namespace ninedot {

/// Copies frames into the tap while somebody reads, as many as are asked for; of the others it counts the latency.
/// Threads: the frame loop's.
class TapObserver final : public FrameObserver {
 public:
  explicit TapObserver(TapWriter& tap) noexcept : tap_(tap) {}
  void observe(const Frame& frame, const Fix& fix, const FrameProcessor& by, const Report& report) noexcept override;

 private:
  TapWriter& tap_;
  TapFrame frame_;
  MonoTime copied_at_{};
};

/// Asks every 20 ms whether somebody reads, and then tells ten times a second what the main thread knows: registers,
/// Modbus clients, the newest lines of the log. Threads: the main thread alone.
class TapOutput final : public Output, public LogListener {
 public:
  /// All must outlive this.
  TapOutput(TapWriter& tap, ModbusServer& modbus, const RegisterCodecOptions& codec, const FrameLoop& frames) noexcept;
  void take(const Report& newest, bool is_new, MonoTime now) override;
  void on_line(const std::string& line, MonoTime now) noexcept override;

 private:
  TapWriter& tap_;
  ModbusServer& modbus_;
  const FrameLoop& frames_;
  MonoTime written_at_{};
  TapService service_;
};

}  // namespace ninedot
