#include "aim/target_motion.h"

#include <algorithm>
#include <cmath>

namespace ninedot {

void TargetMotion::change_to(MonoTime exposed_at, const Eigen::Vector3d& point_base_m) noexcept {
  if (sights_ == 0) velocity_m_s_.setZero();
  // Three sights' worth: what the old target told of the motion counts on.
  sights_ = sights_ > 2 ? 3 : 1;
  point_m_ = point_base_m;
  seen_at_ = exposed_at;
}

void TargetMotion::add(MonoTime exposed_at, const Eigen::Vector3d& point_base_m, std::chrono::duration<double> memory,
                       double trust) noexcept {
  if (sights_ == 0) velocity_m_s_.setZero();
  if (sights_ > 0 && exposed_at <= seen_at_) return;
  const double dt_s = std::chrono::duration<double>(exposed_at - seen_at_).count();
  sights_ = std::min(sights_ + 1, kEnough);
  if (sights_ == 1) {
    point_m_ = point_base_m;
  } else {
    const double fading = memory.count() > 0 ? std::exp(-dt_s / memory.count()) : 0.0;
    const double n = sights_;
    const double place = std::sqrt(trust) * std::max(1 - fading * fading, 2 * (2 * n - 1) / (n * (n + 1)));
    const double velocity = std::max((1 - fading) * (1 - fading), 6 / (n * (n + 1)));
    const Eigen::Vector3d deviation_m = point_base_m - at(exposed_at);
    point_m_ = at(exposed_at) + place * deviation_m;
    velocity_m_s_ += trust * velocity / dt_s * deviation_m;
  }
  seen_at_ = exposed_at;
}

Eigen::Vector3d TargetMotion::at(MonoTime time) const noexcept {
  return point_m_ + std::chrono::duration<double>(time - seen_at_).count() * velocity_m_s_;
}

}  // namespace ninedot
