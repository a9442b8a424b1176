#pragma once
/// A head of two servos behind a bus, which a thread of its own talks to: the frame loop never waits for it.
///
/// The thread sends the newest target, asks at a steady pace how the servos are, and opens the bus anew after a
/// failure, with pauses that double. Whatever it was told last, to go or to rest, is told again to a bus that has come
/// back.
#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <thread>

#include "aim/servo_axis.h"
#include "base/handoff.h"
#include "base/mono_time.h"
#include "drivers/posix/doorbell.h"
#include "drivers/posix/late_device.h"
#include "drivers/servo/servo_bus.h"

namespace ninedot {

/// What becomes of the servos when the head is stopped (the inhibit input) and when it ends.
enum class WhenStopped : std::uint8_t {
  kRelease,  ///< no force, no pulses: a hand can turn them, and a load can
  kHold,     ///< they stay where they are; after the end as well
};

struct BusPanTiltOptions {
  WhenStopped when_stopped = WhenStopped::kRelease;
  std::chrono::milliseconds look_interval{20};  ///< from one question how the servos are to the next
  Backoff reopening = Backoff();                ///< pauses between attempts to open a bus that was lost
};

/// Threads: as PanTilt says, and one thread of its own, an ordinary one. They share handoffs, atomics and an eventfd:
/// neither ever waits for the other. Memory: the constructor's, but for attempts to open a lost bus.
class BusPanTilt final : public PanTilt {
 public:
  using Open = std::function<std::unique_ptr<ServoBus>()>;

  /// Servos that tell where they are stay there until they are told to move. Others get their first pulses for `at`;
  /// one whose pulses still run keeps them, and stands where they say.
  /// \param open  throws StartupError; called here at first, then by the thread
  /// Throws what `open` throws, and DeviceAbsent where the servos can't be driven.
  BusPanTilt(Open open, const BusPanTiltOptions& options, const ServoAxes& axes, const HeadAngles& at);
  /// Releases the servos unless they shall hold. Waits for the transfer that is under way, and tries three times; opens
  /// a lost bus once more for it.
  ~BusPanTilt() override;

  /// Leaves the target for the thread; one write to an eventfd, which does not wait.
  void move_to(const HeadAngles& angles) noexcept override;
  /// The same: releases the servos, or lets them stay where they are.
  void stop() noexcept override;
  /// Angles: as the servos report them, else as they were told last. Failed: the bus or a servo is lost. What the
  /// servos tell: as read last, unknown while the bus is lost.
  HeadState state() const noexcept override;

 private:
  struct Order {
    enum class Kind : std::uint8_t { kDrive, kStop };
    Kind kind = Kind::kStop;
    ServoTargets targets;
    std::uint32_t sequence = 0;  // another one for each order
  };
  struct Seen {
    ServoTargets position;
    bool tells_position = false;
    bool failed = false;
    std::uint32_t losses = 0;
    ServoHealth health;
  };

  void run() noexcept;
  bool reopen() noexcept;
  Result<void> obey(const Order& order) noexcept;
  Result<void> look() noexcept;
  void publish() noexcept;
  void let_go() noexcept;
  void leave(Order::Kind kind) noexcept;

  const Open open_;
  const BusPanTiltOptions options_;
  const ServoAxes axes_;

  // Of the caller.
  Order ordered_;
  bool limited_ = false;

  Handoff<Order> orders_;
  mutable Handoff<Seen> seen_out_;
  std::atomic<bool> ends_{false};

  // Of the thread.
  std::unique_ptr<ServoBus> bus_;
  Seen seen_;
  bool tells_position_ = false;
  std::uint32_t done_ = 0;  // the order that was carried out
  Backoff backoff_;
  DeviceNote problem_;
  MonoTime look_at_{};

  WakeUp stop_;
  Doorbell told_;
  std::thread thread_;
};

}  // namespace ninedot
