#include "drivers/servo/i2c_device.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <linux/i2c-dev.h>
#include <linux/i2c.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <cerrno>

#include "base/contract.h"
#include "drivers/posix/file_descriptor.h"
#include "drivers/posix/late_device.h"
#include "drivers/posix/open_advice.h"

namespace ninedot {
namespace {

constexpr unsigned long kNeeded = I2C_FUNC_SMBUS_BYTE_DATA | I2C_FUNC_SMBUS_WRITE_I2C_BLOCK;

class KernelI2cDevice final : public I2cDevice {
 public:
  explicit KernelI2cDevice(FileDescriptor fd) noexcept : fd_(std::move(fd)) {}

  Result<std::uint8_t> read_register(std::uint8_t address) noexcept override {
    i2c_smbus_data data{};
    if (!transfer(I2C_SMBUS_READ, address, I2C_SMBUS_BYTE_DATA, data))
      return fail(Errc::kIo, "the I2C chip cannot be read", errno);
    return data.byte;
  }
  Result<void> write_register(std::uint8_t address, std::uint8_t value) noexcept override {
    i2c_smbus_data data{};
    data.byte = value;
    return written(transfer(I2C_SMBUS_WRITE, address, I2C_SMBUS_BYTE_DATA, data));
  }
  Result<void> write_registers(std::uint8_t first, std::span<const std::uint8_t> values) noexcept override {
    EXPECTS(!values.empty() && values.size() <= I2C_SMBUS_BLOCK_MAX);
    i2c_smbus_data data{};
    data.block[0] = static_cast<std::uint8_t>(values.size());
    std::ranges::copy(values, data.block + 1);
    return written(transfer(I2C_SMBUS_WRITE, first, I2C_SMBUS_I2C_BLOCK_DATA, data));
  }

 private:
  bool transfer(std::uint8_t direction, std::uint8_t address, std::uint32_t size, i2c_smbus_data& data) const noexcept {
    i2c_smbus_ioctl_data request{direction, address, size, &data};
    int done = 0;
    do done = ::ioctl(fd_.get(), I2C_SMBUS, &request);
    while (done < 0 && errno == EINTR);
    return done >= 0;
  }
  static Result<void> written(bool done) noexcept {
    if (!done) return fail(Errc::kIo, "the I2C chip cannot be written", errno);
    return {};
  }

  FileDescriptor fd_;
};

}  // namespace

std::unique_ptr<I2cDevice> open_i2c_device(const std::string& bus, int address) {
  EXPECTS(address >= 0x08 && address <= 0x77);
  FileDescriptor fd(::open(bus.c_str(), O_RDWR | O_CLOEXEC));
  if (!fd) {
    const int error = errno;
    refuse_device(error == ENOENT ? bus +
                                        ": there is no such I2C bus; enable it (on a Raspberry Pi: "
                                        "dtparam=i2c_arm=on), load i2c-dev, or correct the device of [pan_tilt]"
                                  : open_advice(bus, error),
                  error);
  }
  unsigned long functions = 0;
  if (::ioctl(fd.get(), I2C_FUNCS, &functions) != 0)
    refuse_device(bus + ": this is no I2C bus; correct the device of [pan_tilt]", ENOTTY);
  if ((functions & kNeeded) != kNeeded)
    refuse_device(bus + ": this adapter can't write several registers at once; use another bus", EINVAL);
  if (::ioctl(fd.get(), I2C_SLAVE, static_cast<unsigned long>(address)) != 0) {
    const int error = errno;
    refuse_device(error == EBUSY ? fmt::format("{}: a driver of the kernel has the chip at 0x{:02x}; use it with "
                                               "driver = \"sysfs-pwm\", or take the chip out of the device tree",
                                               bus, address)
                                 : open_advice(bus, error),
                  error == EBUSY ? EBUSY : error);
  }
  return std::make_unique<KernelI2cDevice>(std::move(fd));
}

}  // namespace ninedot
