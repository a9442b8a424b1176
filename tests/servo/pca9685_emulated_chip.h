#pragma once
/// A PCA9685 as its data sheet describes it, behind the seam to the kernel's I2C: with faults on request.
#include <array>
#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "drivers/servo/i2c_device.h"

namespace ninedot::test {

/// What is on the bus; outlives the driver's handles to it.
class EmulatedPca9685 {
 public:
  struct Write {
    int address = 0;
    std::vector<int> values;
    friend bool operator==(const Write&, const Write&) = default;
  };
  std::atomic<int> fails_from{-1};  ///< this many more transfers work, then none; -1: all
  std::atomic<int> fails_at{-1};    ///< after this many more transfers one does not work; -1: none
  std::atomic<int> open_handles{0};

  EmulatedPca9685() { power_cycle(); }
  /// Table 4's values after power-on.
  void power_cycle() {
    const std::lock_guard lock(mutex_);
    registers_.fill(0);
    registers_[0x00] = 0x11;
    registers_[0x01] = 0x04;
    for (int channel = 0; channel < 16; ++channel) registers_[at(channel) + 3] = 0x10;
    registers_[0xFE] = 0x1E;
  }
  void set(int address, int value) {
    const std::lock_guard lock(mutex_);
    registers_[static_cast<std::size_t>(address)] = value;
  }
  int get(int address) const {
    const std::lock_guard lock(mutex_);
    return registers_[static_cast<std::size_t>(address)];
  }
  /// Steps high in each period, as a scope would show them; 0: no pulses, for whatever reason.
  int pulse(int channel) const {
    const std::lock_guard lock(mutex_);
    const std::size_t first = at(channel);
    if ((registers_[0] & 0x10) != 0 || (registers_[first + 3] & 0x10) != 0) return 0;
    const int on = (registers_[first + 1] & 0x0F) << 8 | registers_[first];
    const int off = (registers_[first + 3] & 0x0F) << 8 | registers_[first + 2];
    return (off - on + 4096) % 4096;
  }
  std::vector<Write> writes() const {
    const std::lock_guard lock(mutex_);
    return writes_;
  }
  void forget_writes() {
    const std::lock_guard lock(mutex_);
    writes_.clear();
  }

  std::unique_ptr<I2cDevice> handle() { return std::make_unique<Handle>(*this); }

 private:
  class Handle final : public I2cDevice {
   public:
    explicit Handle(EmulatedPca9685& chip) : chip_(chip) { ++chip_.open_handles; }
    ~Handle() override { --chip_.open_handles; }
    Result<std::uint8_t> read_register(std::uint8_t address) noexcept override {
      if (!chip_.answers()) return fail(Errc::kIo, "made up", EREMOTEIO);
      return static_cast<std::uint8_t>(chip_.get(address));
    }
    Result<void> write_register(std::uint8_t address, std::uint8_t value) noexcept override {
      return write_registers(address, std::span(&value, 1));
    }
    Result<void> write_registers(std::uint8_t first, std::span<const std::uint8_t> values) noexcept override {
      if (!chip_.answers()) return fail(Errc::kIo, "made up", EREMOTEIO);
      chip_.write(first, values);
      return {};
    }

   private:
    EmulatedPca9685& chip_;
  };

  static std::size_t at(int channel) { return 6 + 4 * static_cast<std::size_t>(channel); }
  bool answers() {
    if (fails_at >= 0 && fails_at-- == 0) return false;
    if (fails_from < 0) return true;
    if (fails_from == 0) return false;
    --fails_from;
    return true;
  }
  void write(std::size_t address, std::span<const std::uint8_t> values) {
    const std::lock_guard lock(mutex_);
    writes_.push_back({static_cast<int>(address), {values.begin(), values.end()}});
    for (const std::uint8_t value : values) {
      write_one(address, value);
      if ((registers_[0] & 0x20) != 0) ++address;  // auto-increment
    }
  }
  void write_one(std::size_t address, int value) {
    if (address == 0xFE) {
      if ((registers_[0] & 0x10) != 0 && value >= 3) registers_[address] = value;  // 7.3.5: while asleep only
      return;
    }
    if (address != 0x00) {
      registers_[address] = value;
      return;
    }
    // 7.3.1.1: RESTART is set by falling asleep with outputs running; writing 1 clears it, 0 leaves it.
    bool running = false;
    for (int channel = 0; channel < 16; ++channel) running |= (registers_[at(channel) + 3] & 0x10) == 0;
    int restart = registers_[0] & 0x80;
    if ((registers_[0] & 0x10) == 0 && (value & 0x10) != 0 && running) restart = 0x80;
    if ((value & 0x80) != 0) restart = 0;
    registers_[0] = restart | (value & 0x7F);
  }

  mutable std::mutex mutex_;
  std::array<int, 256> registers_{};
  std::vector<Write> writes_;
};

}  // namespace ninedot::test
