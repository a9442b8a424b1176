#include "drivers/posix/service_manager.h"

#include <systemd/sd-daemon.h>

namespace ninedot {

ServiceManager::ServiceManager() noexcept {
  std::uint64_t interval_us = 0;
  if (sd_watchdog_enabled(0, &interval_us) > 0)
    watchdog_ = std::chrono::microseconds(static_cast<std::int64_t>(interval_us));
}

void ServiceManager::ready() noexcept {
  if (!is_ready_) sd_notify(0, "READY=1");
  is_ready_ = true;
}

void ServiceManager::status(const std::string& line) noexcept { sd_notify(0, ("STATUS=" + line).c_str()); }

void ServiceManager::stopping() noexcept { sd_notify(0, "STOPPING=1"); }

bool ServiceManager::feed_watchdog(std::uint64_t progress, MonoTime now) noexcept {
  if (watchdog_.count() == 0 || progress == fed_progress_ || now - fed_at_ < watchdog_ / 4) return false;
  fed_progress_ = progress;
  fed_at_ = now;
  return sd_notify(0, "WATCHDOG=1") > 0;
}

}  // namespace ninedot
