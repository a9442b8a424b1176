#pragma once
/// Whether the head has done what it was ordered to do.
#include <chrono>

#include "aim/aimer.h"
#include "base/units.h"
#include "report/report.h"

namespace ninedot {

/// What an order's progress is judged by, after each aiming step.
struct ArrivalSight {
  HeadAngles head{};       ///< where it stands, as it says
  bool at_goal = false;    ///< it has been told its goal, or the end of its range in place of it
  bool limited = false;    ///< the set-point lies beyond its range
  bool failed = false;     ///< it could not be moved, or does not answer
  bool inhibited = false;  ///< nothing may move
};

/// Memory: inside. Threads: one.
class Arrival {
 public:
  /// A step of the coarsest head that there is, the EVI-D31's of 100 deg / 880, and the half of one beside it.
  static constexpr double kResolution_rad = 1.5 * 100.0 / 880 * kRadPerDeg;
  /// So long a head must not have moved to count as standing: three of the ten answers a second that a VISCA head
  /// gives.
  static constexpr std::chrono::milliseconds kStanding{300};
  /// A VISCA head may need so long to begin to move: sooner, it is not taken to stand at the end of its range, and one
  /// refused command is no failed head.
  static constexpr std::chrono::seconds kSettled{1};
  /// Over what the way takes at the axes' fastest turn and a quarter more: acceleration, and a slow line.
  static constexpr std::chrono::seconds kGrace{5};

  /// \param options  as the aiming step's
  explicit Arrival(const AimOptions& options) noexcept;

  /// How far `order` has come. An order with another number than the one before begins anew. What is done or failed
  /// stays so until there is another order.
  OrderProgress step(MonoTime now, const AimOrder& order, const ArrivalSight& sight) noexcept;

 private:
  void begin(MonoTime now, const AimOrder& order, const ArrivalSight& sight) noexcept;
  OrderProgress judge(MonoTime now, const AimOrder& order, const ArrivalSight& sight) const noexcept;

  const AimOptions options_;
  const double tolerance_rad_;
  std::uint32_t number_ = 0;
  OrderProgress progress_ = OrderProgress::kNone;
  MonoTime due_{}, still_since_{}, working_at_{};
  HeadAngles still_at_;
};

}  // namespace ninedot
