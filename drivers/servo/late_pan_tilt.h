#pragma once
/// A head whose device may come late, or go and come back: looked for by a thread of its own, never by the frame loop.
///
///     ABSENT   the thread opens the head, with pauses between its attempts; `state` says failed once one has been made
///       | opened, and not before `may_move` allows it, because a servo may move as it gets its first pulse
///     PRESENT  the caller uses the head
///       | the head has failed for kGiveUpAfter
///     ABSENT   the thread closes it, and opens it again
#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "base/mono_time.h"
#include "drivers/posix/late_device.h"
#include "ports/pan_tilt.h"

namespace ninedot {

struct LatePanTiltOptions {
  HeadAngles start;  ///< where it is taken to be before it has been there
  /// Whether the head may move now; asked by the thread. Empty: always.
  std::function<bool()> may_move;
  /// Close and open a head that has failed. False for heads that do so themselves.
  bool reopens_failed = true;
  Backoff backoff = Backoff();
};

/// Memory: none by the caller. Threads: one caller of move_to, stop and state.
class LatePanTilt final : public PanTilt {
 public:
  /// \param at  where the head is taken to be: where it was last, or LatePanTiltOptions::start
  using Open = std::function<std::unique_ptr<PanTilt>(const HeadAngles& at)>;
  /// A head that refuses every command for so long is taken for gone: 35 frames at the usual rate, so that one refused
  /// write does not close it.
  static constexpr std::chrono::seconds kGiveUpAfter{1};

  /// Makes the first attempt itself, unless the head must not move now. Throws what `open` throws then, unless that is
  /// DeviceAbsent.
  /// \param open  throws StartupError; called by the thread from then on
  LatePanTilt(Open open, LatePanTiltOptions options);
  ~LatePanTilt() override;

  /// As the head's own; nothing while it is absent. A target that is still wanted is said again at the next frame.
  void move_to(const HeadAngles& angles) noexcept override;
  void stop() noexcept override;
  /// While the head is absent: absent, the angles of its last state, failed unless no attempt has been made yet.
  HeadState state() const noexcept override;

  /// Why there is no head, or that it failed when `state` was asked last; empty: all is well. Any thread.
  std::string problem() const;

 private:
  enum class Owner : std::uint8_t { kThread, kCaller };

  void run() noexcept;
  void hand_over() noexcept;
  bool wait_until_allowed() noexcept;

  const Open open_;
  LatePanTiltOptions options_;
  DeviceNote problem_;
  std::unique_ptr<PanTilt> head_;  // of its owner
  std::atomic<Owner> owner_{Owner::kThread};
  std::atomic<bool> failed_{false};               // an attempt to open it
  mutable std::atomic<bool> head_failed_{false};  // the head that is there

  // Of the caller, who changes it while the head is there; then, of both, to be read.
  mutable HeadState last_;
  std::optional<MonoTime> failing_since_;

  WakeUp stop_;
  FileDescriptor given_up_;  // an eventfd: the caller has handed the head back
  std::thread thread_;
};

}  // namespace ninedot
