#pragma once
/// Where the landmark is from the head's foot, and how fast it moves there: from the sights so far to any time.
///
/// A robot that drives straight on moves every landmark evenly in the base, however fast its direction turns: so place
/// and velocity are estimated there, by the fading-memory filter of first order (Brown, "Smoothing, Forecasting and
/// Prediction", 1963; Zarchan & Musoff, "Fundamentals of Kalman Filtering", ch. 7): with t = exp(-dt / memory) a sight
/// takes 1 - t^2 of the place's deviation away and (1 - t)^2 / dt into the velocity. Its first sights count by the
/// line of least squares through all of them. The same gains for all axes keep the uncertain distance out of the
/// directions; that they depend on dt alone makes the closed loop linear, with the margins of docs/pan-tilt.md.
#include <Eigen/Core>
#include <chrono>
#include <cstdint>

#include "base/mono_time.h"

namespace ninedot {

/// Memory: inside. Threads: one.
class TargetMotion {
 public:
  /// Forgets everything.
  void reset() noexcept { sights_ = 0; }
  /// Another target, which moves as the one before did.
  void change_to(MonoTime exposed_at, const Eigen::Vector3d& point_base_m) noexcept;

  /// \param exposed_at  later than the one before; else it is no news
  /// \param memory  0 or more; 0: each sight counts for itself
  /// \param trust  in what the sight says of the velocity [1], 0..1: less where the head turned as it was exposed
  void add(MonoTime exposed_at, const Eigen::Vector3d& point_base_m, std::chrono::duration<double> memory,
           double trust = 1) noexcept;

  bool is_known() const noexcept { return sights_ > 0; }
  MonoTime seen_at() const noexcept { return seen_at_; }  ///< exposure of the newest sight

  /// \param time  before or after the newest sight \return  the place then, frame base [m]
  Eigen::Vector3d at(MonoTime time) const noexcept;

 private:
  static constexpr std::uint32_t kEnough = 1000;  // by then the line through all sights counts for nothing

  std::uint32_t sights_ = 0;
  MonoTime seen_at_{};
  Eigen::Vector3d point_m_ = Eigen::Vector3d::Zero(), velocity_m_s_ = Eigen::Vector3d::Zero();
};

}  // namespace ninedot
