#include "programs/web/frame_taker.h"

#include <algorithm>

#include "base/startup_error.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

// A tap that is not there is looked for as often; likewise whether the service behind it still lives.
constexpr auto kLookPeriod = 500ms;
constexpr auto kRest = 1h;

/// A slot is used again after two more frames: looking eight times in a period none is lost.
std::chrono::nanoseconds pause_of(double rate_hz) {
  const std::chrono::duration<double> period(1 / std::clamp(rate_hz, 1.0, 1000.0));
  return std::clamp<std::chrono::nanoseconds>(std::chrono::duration_cast<std::chrono::nanoseconds>(period) / 8, 500us,
                                              5ms);
}

}  // namespace

void FrameTaker::open(MonoTime now) {
  looked_at_ = now;
  try {
    tap_.emplace(path_);
    tap_->announce(TapDemand::kEvery);
    header_ = std::make_shared<const TapHeader>(tap_->header());
    queue_.reserve(header_->pixels_capacity);
    frame_.copy.publication = 0;
    trouble_.clear();
  } catch (const StartupError& error) {
    trouble_ = error.what();
  }
}

std::chrono::nanoseconds FrameTaker::look(MonoTime now) {
  if (tap_ && now - looked_at_ >= kLookPeriod) {
    looked_at_ = now;
    if (!tap_->is_alive()) tap_.reset();
  }
  if (!tap_) open(now);
  if (!tap_) return kLookPeriod;
  if (tap_->copy_newest(frame_.copy)) {
    const std::uint64_t seen = frame_.copy.publication;
    frame_.header = header_;
    queue_.push(frame_);
    // What was swapped in is an older frame's buffer; of a full queue it is the frame itself, which is lost.
    frame_.copy.publication = seen;
  }
  return pause_of(header_->rate_hz);
}

std::chrono::nanoseconds FrameTaker::rest() {
  tap_.reset();
  frame_ = {};
  queue_.clear();
  trouble_.clear();
  return kRest;
}

}  // namespace ninedot
