#pragma once
/// Devices that may come late: why one is not there yet, told by the thread that looks for it, and the looking itself.
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "base/startup_error.h"
#include "drivers/posix/backoff.h"

namespace ninedot {

/// A device is not there, in use, or not permitted: what waiting may mend, unlike a setting that is wrong in itself,
/// which is a plain StartupError. One line that says what to do.
class DeviceAbsent : public StartupError {
 public:
  explicit DeviceAbsent(const std::string& line, ExitStatus exit_status = ExitStatus::kWrongUsage)
      : StartupError(exit_status, line) {}
};

/// Throws for `error`, the errno of an attempt to open a device: DeviceAbsent, or StartupError(kWrongUsage) where the
/// name is of something that will never be such a device: no terminal, a folder, a rate that it does not have.
[[noreturn]] void refuse_device(const std::string& line, int error);

/// One line about a device, from the thread that opens it to the one that writes the log: why it is not in use (empty:
/// it is), or what there is to say about it. Memory: allocates. Threads: any.
class DeviceNote {
 public:
  void set(std::string line) {
    const std::lock_guard lock(mutex_);
    line_ = std::move(line);
  }
  std::string read() const {
    const std::lock_guard lock(mutex_);
    return line_;
  }

 private:
  mutable std::mutex mutex_;
  std::string line_;
};

/// One attempt. \return  null: refused, and `problem` says why; else it is empty
template <typename Device>
std::unique_ptr<Device> try_open(const std::function<std::unique_ptr<Device>()>& open, DeviceNote& problem) noexcept {
  try {
    std::unique_ptr<Device> device = open();
    problem.set("");
    return device;
  } catch (const std::exception& refused) {
    problem.set(refused.what());
    return nullptr;
  }
}

/// Attempts with pauses between them, a pause first. \return  null: `stop` was rung
template <typename Device>
std::unique_ptr<Device> open_patiently(const std::function<std::unique_ptr<Device>()>& open, Backoff& backoff,
                                       const WakeUp& stop, DeviceNote& problem) noexcept {
  while (!is_rung_within(stop, backoff.next()))
    if (std::unique_ptr<Device> device = try_open(open, problem)) return device;
  return nullptr;
}

}  // namespace ninedot
