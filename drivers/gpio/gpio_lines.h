#pragma once
/// GPIO lines by name: "servo-power", or chip label and offset where lines have no names: "pinctrl-bcm2711:18".
/// Never by a chip's number, which changes with kernels and overlays.
#include <atomic>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <thread>

#include "base/mono_time.h"
#include "drivers/gpio/gpio_kernel.h"
#include "drivers/posix/late_device.h"
#include "ports/digital_io.h"

namespace ninedot {

struct GpioLineOptions {
  std::string line;  ///< "NAME", or "LABEL:OFFSET"
  bool active_low = false;
  GpioBias bias = GpioBias::kUnchanged;  ///< of an input
};

/// Where a line is, and that it is free. Throws DeviceAbsent: no chip has it (with what to look at), in use (by whom),
/// permission missing (for which group); StartupError(kWrongUsage): its chip is there, and has no such offset.
/// \param chips  list_gpio_chips(), or a test's own
/// Memory: allocates. Threads: pure.
GpioRequest find_gpio_line(const GpioLineOptions& options, std::span<const GpioChip> chips);

/// Not active at first. The destructor makes it inactive before it gives the line back; after a crash the kernel gives
/// it back, and then its level is the board's: most drivers make it an input, so a resistor has to pull it to "off".
/// Throws as find_gpio_line. Memory: allocates here, not in `set`. Threads: any here, then one owner (DigitalOutput).
std::unique_ptr<DigitalOutput> open_gpio_output(const GpioLineOptions& options);

/// Throws as find_gpio_line.
std::unique_ptr<GpioHandle> open_gpio_handle(const GpioLineOptions& options);

/// An output that is opened when it is there, and again when it was gone: for a lamp, which nobody waits for.
/// Threads: one caller.
class LateGpioOutput final : public DigitalOutput {
 public:
  using Open = std::function<std::unique_ptr<DigitalOutput>()>;

  /// \param open  as open_gpio_output, called by `set`, at most once per pause: opening takes some milliseconds
  explicit LateGpioOutput(Open open, const Backoff& backoff = Backoff()) noexcept
      : open_(std::move(open)), backoff_(backoff) {}
  /// \error  kIo: ENODEV while it is not there
  Result<void> set(bool active) noexcept override;
  /// Why it is not in use; empty: it is. Any thread.
  std::string problem() const { return problem_.read(); }

 private:
  const Open open_;
  Backoff backoff_;
  MonoTime attempt_at_{};
  std::unique_ptr<DigitalOutput> output_;
  DeviceNote problem_;
};

/// An input that inhibits. Its thread follows the edges, so that asking costs nothing, and opens the line when its chip
/// comes, also when it comes back. Active while the line is not there, or cannot be watched or read.
class InhibitInput final : public DigitalInput {
 public:
  using Open = std::function<std::unique_ptr<GpioHandle>()>;

  /// \param open  as open_gpio_handle. Throws what it throws at the first attempt, unless that is DeviceAbsent.
  explicit InhibitInput(Open open, const Backoff& backoff = Backoff());
  ~InhibitInput() override;
  InhibitInput(const InhibitInput&) = delete;
  InhibitInput& operator=(const InhibitInput&) = delete;

  bool is_active() const noexcept override { return active_.load(std::memory_order_relaxed); }
  /// Why the line is not watched; empty: it is. Any thread.
  std::string problem() const { return problem_.read(); }

 private:
  enum class Look { kLevel, kLost, kStopping };

  void run() noexcept;
  /// Waits for an edge until `wake_at` at most, and takes the level over.
  Look look(MonoTime wake_at) noexcept;

  const Open open_;
  Backoff backoff_;
  DeviceNote problem_;
  WakeUp stop_;
  std::unique_ptr<GpioHandle> handle_;
  std::atomic<bool> active_{true};
  std::thread thread_;
};

}  // namespace ninedot
