#pragma once
/// GPIO lines by name: "servo-power", or chip label and offset where lines have no names: "pinctrl-bcm2711:18".
/// Never by a chip's number, which changes with kernels and overlays.
#include <memory>
#include <span>
#include <string>

#include "drivers/gpio/gpio_kernel.h"
#include "ports/digital_io.h"

namespace ninedot {

struct GpioLineOptions {
  std::string line;  ///< "NAME", or "LABEL:OFFSET"
  bool active_low = false;
  GpioBias bias = GpioBias::kUnchanged;  ///< of an input
};

/// Where a line is, and that it is free. Throws StartupError(kWrongUsage): no such line (with what to look at), in use
/// (by whom), permission missing (for which group).
/// \param chips  list_gpio_chips(), or a test's own
/// Memory: allocates. Threads: pure.
GpioRequest find_gpio_line(const GpioLineOptions& options, std::span<const GpioChip> chips);

/// Not active at first. The destructor makes it inactive before it gives the line back; after a crash the kernel gives
/// it back, and then its level is the board's: most drivers make it an input, so a resistor has to pull it to "off".
/// Throws as find_gpio_line. Memory: allocates here, not in `set`. Threads: any here, then one owner (DigitalOutput).
std::unique_ptr<DigitalOutput> open_gpio_output(const GpioLineOptions& options);

/// Follows the edges in a thread of its own, an ordinary one that sleeps in poll(). Asking is one relaxed atomic load,
/// from any thread; an edge is seen once that thread has run. Destroy it when nobody asks any more: that waits for the
/// thread. Throws as find_gpio_line.
std::unique_ptr<DigitalInput> open_gpio_input(const GpioLineOptions& options);

/// The same, for a handle that is there already and that nobody else uses any more. A handle that fails counts as
/// active: an inhibit input that cannot be read inhibits.
std::unique_ptr<DigitalInput> watch_gpio_input(std::unique_ptr<GpioHandle> handle);

}  // namespace ninedot
