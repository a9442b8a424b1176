#pragma once
/// Requests on their way round: the camera's thread completes them, the frame loop takes the newest and gives it back,
/// and a thread of this object queues them again.
///
/// Queueing is not the frame loop's: libcamera allocates for it (a message to its own thread, the maps of controls) and
/// takes locks that its ordinary threads hold. Nothing of libcamera is in here; it goes behind `queue_again`.
#include <atomic>
#include <functional>
#include <thread>

#include "base/result.h"
#include "drivers/posix/doorbell.h"
#include "drivers/posix/newest_wins.h"

namespace ninedot {

/// Memory: none after the construction. Threads: see each method.
class RequestExchange {
 public:
  /// \param queue_again  called on the thread of this object with the number of a request, below NewestWins::kCapacity
  explicit RequestExchange(std::function<void(std::uint32_t request)> queue_again);
  ~RequestExchange() { stop(); }
  RequestExchange(const RequestExchange&) = delete;
  RequestExchange& operator=(const RequestExchange&) = delete;

  /// The request has a picture; the newest wins, and the one that it replaces is queued again.
  /// \param request  its number [1]. Threads: one, the camera's.
  void complete(std::uint32_t request) noexcept;
  /// The request's picture is damaged: it is counted and queued again.
  /// \param request  its number [1]. Threads: the camera's.
  void complete_damaged(std::uint32_t request) noexcept;
  /// From now on `take` fails. \param why  a literal. Threads: any.
  void lose(const char* why) noexcept;

  /// The newest completed request. Waits at most until `deadline`, and never for a lock.
  /// \error kNoFrame, kCameraLost. Threads: one, the frame loop's.
  Result<NewestWins::Taken> take(MonoTime deadline) noexcept;
  /// Returns at once. \param request  its number [1]. Threads: any, in real time as well.
  void give_back(std::uint32_t request) noexcept;

  /// After this nothing is queued again. Threads: the one that made this object.
  void stop() noexcept;

 private:
  void run() noexcept;

  const std::function<void(std::uint32_t)> queue_again_;
  NewestWins newest_;
  std::uint32_t damaged_ = 0;  // the camera's thread; since the last good one
  std::atomic<const char*> lost_{nullptr};
  std::atomic<std::uint32_t> returned_{0};  // a bit for each request
  std::atomic<bool> stop_{false};
  Doorbell completed_;  // for `take`
  Doorbell to_queue_;   // for the thread
  std::thread thread_;
};

}  // namespace ninedot
