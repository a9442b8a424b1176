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
/// publishing meanwhile.
#include <array>
#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "drivers/camera/camera_device.h"
#include "ports/frame_source.h"

namespace ninedot {

struct ReopenOptions {
  int stall_periods = 10;  ///< frame periods without a frame: the camera is lost
  /// Cameras take their time to the first frame: automatic exposure, USB negotiation.
  std::chrono::nanoseconds first_frame_within = std::chrono::seconds(3);
  std::chrono::nanoseconds first_pause = std::chrono::milliseconds(100);
  std::chrono::nanoseconds longest_pause = std::chrono::seconds(5);
  bool wait_for_device = false;  ///< a camera that can't be opened at first counts as lost, instead of an exception
};

/// FrameLease::frame_number grows for ever, across openings. A frame counts as dropped when the device's sequence skips
/// it or a newer one replaced it; damaged ones are counted apart, in SourceCounters::flagged.
/// Memory: nothing of ours is allocated by `next`. Threads: one caller of `next`; leases may be given back by any.
class ReopeningSource final : public FrameSource, private FrameOwner {
 public:
  /// Opens the device. Throws CameraRefused, unless options.wait_for_device.
  ReopeningSource(std::unique_ptr<CameraDevice> device, const ReopenOptions& options);
  ~ReopeningSource() override;
  ReopeningSource(const ReopeningSource&) = delete;
  ReopeningSource& operator=(const ReopeningSource&) = delete;

  Result<FrameLease> next(MonoTime deadline) noexcept override;
  SourceCounters counters() const noexcept override;

  /// What the device agreed to at its newest opening, or why the newest attempt to open it failed. Allocates.
  std::string description() const;

 private:
  enum class State { kRunning, kLost };

  void give_back(std::uint32_t buffer) noexcept override;
  FrameLease lend(const GrabbedFrame& grabbed) noexcept;
  tl::unexpected<Error> lose(const Error& error) noexcept;
  void note_opened() noexcept;
  bool try_open() noexcept;
  void supervise() noexcept;

  const std::unique_ptr<CameraDevice> device_;
  const ReopenOptions options_;

  mutable std::mutex mutex_;
  std::condition_variable changed_;
  State state_ = State::kLost;
  bool stop_ = false;
  int lent_ = 0;
  std::chrono::nanoseconds pause_;                              // before the next attempt
  Error lost_{Errc::kCameraLost, 0, "the camera is not open"};  // why `next` fails
  std::string description_;

  // The caller of `next` while running, the supervisor while lost; handed over with state_.
  bool has_delivered_ = false;  // since the newest opening
  bool was_open_ = false;
  std::chrono::nanoseconds stall_after_{};
  MonoTime expected_by_{};  // no frame by then: stalled
  std::uint32_t last_sequence_ = 0;

  std::uint64_t frame_number_ = 0;
  bool has_number_ = false;
  std::atomic<std::uint32_t> restarts_{0};
  std::atomic<std::uint32_t> flagged_{0};
  std::thread supervisor_;
};

}  // namespace ninedot
