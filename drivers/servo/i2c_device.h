#pragma once
/// One chip on an I2C bus, through the kernel's /dev/i2c-N: the one seam to it, where tests put faults.
///
/// SMBus transfers (Documentation/i2c/dev-interface.rst), which every adapter has, and the kernel's own i2c-stub too.
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "base/result.h"

namespace ninedot {

/// Every transfer waits for the bus: some 0.1 ms per byte at 100 kHz, and where an adapter hangs as long as its driver
/// lets it, usually a second. Memory: none. Threads: one at a time. \error  kIo with errno: EREMOTEIO, ENXIO: nobody
/// answers at this address
class I2cDevice {
 public:
  virtual ~I2cDevice() = default;
  virtual Result<std::uint8_t> read_register(std::uint8_t address) noexcept = 0;
  virtual Result<void> write_register(std::uint8_t address, std::uint8_t value) noexcept = 0;
  /// Several registers from `first` on in one transfer: the chip has to count them up by itself.
  /// \param values  1 to 32 of them (contract)
  virtual Result<void> write_registers(std::uint8_t first, std::span<const std::uint8_t> values) noexcept = 0;
};

/// \param bus  "/dev/i2c-1"
/// \param address  7 bits: 0x08..0x77 (contract)
/// Throws DeviceAbsent, one line that says what to do: no such bus, permission missing, a driver of the kernel has the
/// chip; StartupError(kWrongUsage): this is no I2C bus, or one that can't do such transfers. Says nothing about whether
/// a chip is there. Memory: allocates. Threads: any, at start-up.
std::unique_ptr<I2cDevice> open_i2c_device(const std::string& bus, int address);

}  // namespace ninedot
