#include "drivers/servo/powered_head.h"

#include <cstring>
#include <string>
#include <utility>

#include "drivers/posix/late_device.h"

namespace ninedot {
namespace {

class PoweredHead final : public PanTilt {
 public:
  PoweredHead(std::unique_ptr<PanTilt> servos, std::unique_ptr<DigitalOutput> power) noexcept
      : servos_(std::move(servos)), power_(std::move(power)) {}
  void move_to(const HeadAngles& angles) noexcept override { servos_->move_to(angles); }
  void stop() noexcept override { servos_->stop(); }
  HeadState state() const noexcept override { return servos_->state(); }

 private:
  const std::unique_ptr<PanTilt> servos_;
  const std::unique_ptr<DigitalOutput> power_;  // after servos_: destroyed first
};

}  // namespace

std::unique_ptr<PanTilt> PoweredHeadOpener::open() {
  if (!servos_) servos_ = open_servos_();
  std::unique_ptr<DigitalOutput> power;
  if (open_power_) {
    power = open_power_();
    if (const Result<void> done = power->set(true); !done)
      throw DeviceAbsent(std::string("the servos' power: ") + done.error().text + ": " +
                         std::strerror(done.error().os_errno));
  }
  return std::make_unique<PoweredHead>(std::move(servos_), std::move(power));
}

}  // namespace ninedot
