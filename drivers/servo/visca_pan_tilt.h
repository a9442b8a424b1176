#pragma once
/// A pan/tilt/zoom camera on a serial line that speaks VISCA, of the Sony EVI-D31 kind.
///
/// A thread of its own sends the newest target and asks about ten times a second where the head stands. The line takes
/// 17 ms for a motion, and as long for a question with its answer; the frame loop never waits for it.
#include <atomic>
#include <cstdint>
#include <optional>
#include <string>
#include <thread>

#include "aim/servo_axis.h"
#include "base/handoff.h"
#include "drivers/posix/backoff.h"
#include "drivers/posix/file_descriptor.h"
#include "drivers/servo/serial_line.h"
#include "drivers/servo/visca_dialogue.h"
#include "drivers/servo/visca_options.h"

namespace ninedot {

/// After a time-out, and when the serial port has vanished, the port is opened anew after a wait that doubles from one
/// attempt to the next; addresses, zoom and the newest target are set again.
///
/// Threads: as PanTilt says, and one thread of its own, an ordinary one. The two share lock-free atomics of one word
/// each and an eventfd: neither ever waits for the other. Memory: the constructor's.
class ViscaPanTilt final : public PanTilt {
 public:
  /// Sets addresses and zoom, and asks for the position, where the head stays until it is told to move.
  /// \param axes  angles to steps as the camera counts them
  /// Waits for the camera: as long as its lens takes, zoom_timeout at most.
  /// Throws StartupError(kWrongUsage), one line that says what to do, for an option out of its range and for a device
  /// that is no serial port; DeviceAbsent for a port that can't be opened, and when no camera answers within
  /// answer_timeout or the lens does not reach its zoom.
  ViscaPanTilt(const ViscaOptions& options, const ServoAxes& axes);
  /// A motion under way goes on to its target. Waits for the thread, which waits for nobody by then.
  ~ViscaPanTilt() override;

  /// Leaves the target for the thread: an atomic store and at most one write to an eventfd, which does not wait.
  void move_to(const HeadAngles& angles) noexcept override;
  /// The same.
  void stop() noexcept override;
  /// Angles: as the head reported them last. Failed: no answer for answer_timeout, the port is gone, or the newest
  /// command was refused. Atomic loads.
  HeadState state() const noexcept override;

  /// The lens as it was read back [steps]; none unless the options set a zoom. Threads: any; an atomic load.
  std::optional<int> zoom() const noexcept;
  /// How often the camera was lost. Threads: any.
  std::uint64_t losses() const noexcept { return losses_.load(std::memory_order_relaxed); }

 private:
  enum class LineState : std::uint8_t { kGood, kLost, kStopping };

  void start();
  void run() noexcept;
  LineState talk(bool until_ready) noexcept;
  LineState wait_and_receive() noexcept;
  bool reopen() noexcept;
  void leave_order(ViscaOrder::Kind kind, const ViscaPosition& position) noexcept;
  void publish() noexcept;

  const ViscaOptions options_;
  const ServoAxes axes_;
  bool limited_ = false;              // of the caller
  std::atomic<std::uint64_t> order_;  // the caller writes, the thread reads: newest wins
  std::atomic<std::uint32_t> position_{0};
  std::atomic<bool> failed_{true};
  std::atomic<int> zoom_{-1};                             // -1: not set by us
  mutable Handoff<std::optional<ZoomStand>> zoom_stand_;  // the thread puts, the caller takes
  std::atomic<std::uint64_t> losses_{0};

  ViscaDialogue dialogue_;
  std::optional<SerialLine> tty_;
  Backoff backoff_;
  WakeUp stop_;
  FileDescriptor ordered_;  // an eventfd
  std::thread thread_;
};

/// Opens the port and closes it again, without a word to the camera. Throws as ViscaPanTilt does. Threads: any; at
/// start-up.
void check_visca_port(const std::string& device);

}  // namespace ninedot
