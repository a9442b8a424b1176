#include "drivers/servo/powered_head.h"

#include <cstring>
#include <string>
#include <utility>

#include "drivers/posix/late_device.h"

namespace ninedot {
namespace {

class PoweredHead final : public PanTilt {
 public:
  PoweredHead(std::unique_ptr<PanTilt> servos, std::unique_ptr<DigitalOutput> power, PowerComes power_comes) noexcept
      : servos_(std::move(servos)), power_(std::move(power)), power_comes_(power_comes) {}
  ~PoweredHead() override {
    if (power_comes_ == PowerComes::kLast) power_.reset();
    servos_.reset();
  }
  PoweredHead(const PoweredHead&) = delete;
  PoweredHead& operator=(const PoweredHead&) = delete;
  void move_to(const HeadAngles& angles) noexcept override { servos_->move_to(angles); }
  void stop() noexcept override { servos_->stop(); }
  HeadState state() const noexcept override { return servos_->state(); }

 private:
  std::unique_ptr<PanTilt> servos_;
  std::unique_ptr<DigitalOutput> power_;
  const PowerComes power_comes_;
};

std::unique_ptr<DigitalOutput> switched_on(std::unique_ptr<DigitalOutput> power) {
  if (const Result<void> done = power->set(true); !done)
    throw DeviceAbsent(std::string("the servos' power: ") + done.error().text + ": " +
                       std::strerror(done.error().os_errno));
  return power;
}

}  // namespace

std::unique_ptr<PanTilt> PoweredHeadOpener::open(const HeadAngles& at) {
  const auto open_servos = [&] {
    if (!servos_) servos_ = open_servos_(at);
  };
  if (power_comes_ == PowerComes::kLast) open_servos();
  if (open_power_ && !power_) power_ = switched_on(open_power_());
  if (power_comes_ == PowerComes::kFirst) open_servos();
  return std::make_unique<PoweredHead>(std::move(servos_), std::move(power_), power_comes_);
}

}  // namespace ninedot
