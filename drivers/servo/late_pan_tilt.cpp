// Who may touch the head is one atomic word: the thread stores kCaller when it has opened it, the caller stores kThread
// when it gives it up. So the frame loop never waits for the thread, and the thread never for the frame loop.
#include "drivers/servo/late_pan_tilt.h"

#include <poll.h>
#include <pthread.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <span>

#include "drivers/posix/poll_until.h"

namespace ninedot {
namespace {

/// How often the thread asks whether the head may move: no slower than a person notices.
constexpr std::chrono::milliseconds kAskAgain{20};

}  // namespace

LatePanTilt::LatePanTilt(Open open, LatePanTiltOptions options)
    : open_(std::move(open)), options_(std::move(options)), given_up_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!given_up_) throw StartupError(ExitStatus::kWorkFailed, "no more descriptors: raise the limit of open files");
  last_.angles = options_.start;
  if (!options_.may_move || options_.may_move()) {
    try {
      head_ = open_(last_.angles);
    } catch (const DeviceAbsent& absent) {
      problem_.set(absent.what());
      failed_ = true;
    }
  }
  if (head_) hand_over();
  thread_ = std::thread([this]() noexcept { run(); });
}

LatePanTilt::~LatePanTilt() {
  stop_.ring();
  thread_.join();
}

std::string LatePanTilt::problem() const {
  std::string problem = problem_.read();
  if (problem.empty() && head_failed_.load(std::memory_order_relaxed))
    problem = "the head does not answer, or does not do what it is told";
  return problem;
}

void LatePanTilt::hand_over() noexcept {
  head_failed_.store(false, std::memory_order_relaxed);
  failed_.store(false, std::memory_order_relaxed);
  owner_.store(Owner::kCaller, std::memory_order_release);
}

void LatePanTilt::run() noexcept {
  ::pthread_setname_np(::pthread_self(), "pan/tilt");
  for (;;) {
    if (owner_.load(std::memory_order_acquire) == Owner::kThread) {
      if (head_) problem_.set("the head takes no commands");
      head_.reset();
      if (!wait_until_allowed()) return;
      const std::function<std::unique_ptr<PanTilt>()> open = [this] { return open_(last_.angles); };
      head_ = try_open(open, problem_);
      if (head_) {
        options_.backoff.reset();
        hand_over();
      } else {
        failed_.store(true, std::memory_order_relaxed);
        if (is_rung_within(stop_, options_.backoff.next())) return;
        continue;
      }
    }
    std::array<pollfd, 2> polled{{{stop_.get(), POLLIN, 0}, {given_up_.get(), POLLIN, 0}}};
    if (poll_until(polled, MonoTime::max()) <= 0) continue;
    if (polled[0].revents != 0) return;
    std::uint64_t count = 0;
    [[maybe_unused]] const auto got = ::read(given_up_.get(), &count, sizeof count);
  }
}

bool LatePanTilt::wait_until_allowed() noexcept {
  while (options_.may_move && !options_.may_move()) {
    problem_.set("the inhibit input is active, and opening the head would move it");
    if (is_rung_within(stop_, kAskAgain)) return false;
  }
  return true;
}

void LatePanTilt::move_to(const HeadAngles& angles) noexcept {
  if (owner_.load(std::memory_order_acquire) != Owner::kCaller) return;
  head_->move_to(angles);
  if (!options_.reopens_failed) return;
  last_ = head_->state();
  if (!last_.failed) {
    failing_since_.reset();
    return;
  }
  const MonoTime now = mono_now();
  if (!failing_since_) failing_since_ = now;
  if (now - *failing_since_ < kGiveUpAfter) return;
  failing_since_.reset();
  failed_.store(true, std::memory_order_relaxed);
  owner_.store(Owner::kThread, std::memory_order_release);
  const std::uint64_t one = 1;
  [[maybe_unused]] const auto written = ::write(given_up_.get(), &one, sizeof one);
}

void LatePanTilt::stop() noexcept {
  if (owner_.load(std::memory_order_acquire) == Owner::kCaller) head_->stop();
}

HeadState LatePanTilt::state() const noexcept {
  if (owner_.load(std::memory_order_acquire) == Owner::kCaller) {
    last_ = head_->state();
    head_failed_.store(last_.failed, std::memory_order_relaxed);
    return last_;
  }
  HeadState state = last_;
  state.absent = true;
  state.zoom.reset();
  state.failed = failed_.load(std::memory_order_relaxed);
  return state;
}

}  // namespace ninedot
