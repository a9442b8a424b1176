#pragma once
/// The little that is used of libgpiod, the same for its versions 1.6 and 2.x: gpio_kernel_v1.cpp and
/// gpio_kernel_v2.cpp implement it, one of them is compiled.
#include <memory>
#include <string>
#include <vector>

#include "base/result.h"

namespace ninedot {

struct GpioLine {
  std::string name;      ///< as the device tree calls it; empty: none
  std::string consumer;  ///< who uses it; empty: nobody
};

struct GpioChip {
  std::string path;   ///< "/dev/gpiochip0": changes with kernels and overlays
  std::string label;  ///< "pinctrl-bcm2711": does not
  std::vector<GpioLine> lines;
  int open_errno = 0;  ///< not 0: it could not be opened, and label and lines are unknown
};

enum class GpioBias { kUnchanged, kPullUp, kPullDown };

struct GpioRequest {
  std::string chip_path;
  unsigned offset = 0;  ///< number of the line in its chip, from 0
  bool active_low = false;
  std::string consumer = "ninedot";  ///< what others see as the user of the line
};

/// One line, ours from the request to the destructor. The kernel takes it back when the process dies, however it dies.
/// Memory: none after the request. Threads: one at a time for all methods, but `event_fd`: any. Nothing takes a lock of
/// this process; a line of a processor does not wait, one of an I2C or SPI expander waits for the bus.
class GpioHandle {
 public:
  virtual ~GpioHandle() = default;
  /// \error  kIo with errno
  virtual Result<void> set(bool active) noexcept = 0;
  /// \return  whether it is active \error  kIo with errno
  virtual Result<bool> get() noexcept = 0;
  /// Becomes readable at an edge; of an input only. -1: there is none. The descriptor stays the handle's.
  virtual int event_fd() const noexcept = 0;
  /// Forgets the edges that were seen so far. Waits for one where there is none: call it when poll() says POLLIN.
  virtual void drop_events() noexcept = 0;
};

/// All chips, in the order of their paths. Memory: allocates. Threads: any; waits for the kernel: at start-up.
std::vector<GpioChip> list_gpio_chips();

/// Null: refused, errno says why. Both requests: memory: allocate. Threads: any; at start-up.
std::unique_ptr<GpioHandle> request_gpio_output(const GpioRequest& request, bool active);
/// Watches both edges. Null: refused, errno says why.
std::unique_ptr<GpioHandle> request_gpio_input(const GpioRequest& request, GpioBias bias);

}  // namespace ninedot
