#pragma once
/// Frames of a camera that may vanish: RUN -> LOST -> REOPEN, by itself, for as long as it takes.
///
///     RUN     `next` takes frames from the device
///       | the device fails, or gives no frame for `stall_periods` frame periods
///     LOST    `next` fails with kCameraLost; once all leases are back the device is closed
///       | after a pause: 0.1 s, doubling up to 5 s until a frame has come
///     REOPEN  the device is opened and its controls are set again; on success RUN, else LOST
///
/// Closing and opening may block for a second: a thread of this object does both, so that the frame loop goes on
/// publishing meanwhile. While the camera runs, that thread asks it what changed (CameraDevice::refresh).
#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "drivers/camera/camera_device.h"
#include "drivers/posix/backoff.h"
#include "drivers/posix/doorbell.h"
#include "ports/frame_source.h"

namespace ninedot {

struct ReopenOptions {
  /// Frame periods without a frame: the camera is lost. The configuration's default, camera.stall_frames.
  int stall_periods = 10;
  /// Cameras take their time to the first frame: automatic exposure, USB negotiation. The kernel's test camera has
  /// frames again 1.0 s after its signal is back, an attempt in vain included (docs/hil.md); three times that.
  std::chrono::nanoseconds first_frame_within = std::chrono::seconds(3);
  std::chrono::nanoseconds first_pause = Backoff::kFirst;
  std::chrono::nanoseconds longest_pause = Backoff::kLongest;
  bool wait_for_device = false;  ///< a camera that can't be opened at first counts as lost, instead of an exception
};

/// Frame::number grows for ever, across openings. A frame counts as dropped when the device's sequence skips it or a
/// newer one replaced it; damaged ones are counted apart, in SourceCounters::flagged.
///
/// Memory: nothing of ours is allocated by `next`. Threads: see each method; leases may be given back by any thread,
/// which waits for no lock either.
class ReopeningSource final : public FrameSource, private FrameOwner {
 public:
  /// Opens the device. Throws CameraRefused, unless options.wait_for_device: then it goes on trying, whatever the
  /// refusal.
  ReopeningSource(std::unique_ptr<CameraDevice> device, const ReopenOptions& options);
  ~ReopeningSource() override;
  ReopeningSource(const ReopeningSource&) = delete;
  ReopeningSource& operator=(const ReopeningSource&) = delete;

  /// Threads: one caller; works on atomics alone and never waits for a lock.
  Result<FrameLease> next(MonoTime deadline) noexcept override;
  /// Threads: any; waits for nobody.
  SourceCounters counters() const noexcept override;

  /// What the device agreed to at its newest opening, or why the newest attempt to open it failed. Allocates, and
  /// waits for the thread that opens. Threads: any but the frame loop's.
  std::string description() const;
  /// Why the newest attempt to open the device failed, one line for the user; empty once it was opened. Some
  /// refusals mend themselves (no such device, busy), others wait for a person (a format that it does not have):
  /// whoever logs this when it changes tells them apart for the reader. Allocates, and waits as above. Threads: any
  /// but the frame loop's.
  std::string last_refusal() const;

 private:
  enum class State { kRunning, kLost };

  void give_back(std::uint32_t buffer) noexcept override;
  FrameLease lend(const GrabbedFrame& grabbed) noexcept;
  tl::unexpected<Error> lose(const Error& error) noexcept;
  tl::unexpected<Error> why_lost() const noexcept;
  void note_opened();
  bool try_open() noexcept;
  void note_refusal(int os_errno, const char* line) noexcept;
  void supervise() noexcept;
  bool tend_until_lost() noexcept;

  const std::unique_ptr<CameraDevice> device_;
  const ReopenOptions options_;

  std::atomic<State> state_{State::kLost};
  std::atomic<int> lent_{0};
  /// What an attempt to open was refused with, since the loss: its errno; kNotTried before the first one.
  static constexpr int kNotTried = -1;
  std::atomic<int> refused_errno_{kNotTried};
  Doorbell opened_;   // for `next`
  Doorbell changed_;  // for the supervisor: lost, or the last lease is back
  WakeUp stop_;

  // The caller of `next` while running, the supervisor while lost; handed over with state_.
  bool has_delivered_ = false;  // since the newest opening
  bool was_open_ = false;
  std::chrono::nanoseconds stall_after_{};
  MonoTime expected_by_{};  // no frame by then: stalled
  std::uint32_t last_sequence_ = 0;

  // The caller of `next`.
  Error lost_{Errc::kCameraLost, 0, "the camera is not open"};
  std::uint64_t frame_number_ = 0;
  bool has_number_ = false;

  Backoff backoff_;  // the supervisor

  mutable std::mutex texts_mutex_;  // never the frame loop's
  std::string description_, refusal_;

  std::atomic<std::uint32_t> restarts_{0};
  std::atomic<std::uint32_t> flagged_{0};
  std::thread supervisor_;
};

}  // namespace ninedot
