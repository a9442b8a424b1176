#include "pipeline/lens.h"

#include <cmath>

#include "base/contract.h"
#include "base/futex.h"

namespace ninedot {

void LensExchange::ask(int zoom) noexcept {
  EXPECTS(zoom >= 0);
  const auto wish = static_cast<std::uint32_t>(zoom) + 1;
  if (wish_.exchange(wish, std::memory_order_relaxed) != wish) futex_wake_all(wish_);
}

std::optional<int> LensExchange::wait_for_wish(std::optional<int> than, MonoTime deadline) const noexcept {
  const std::uint32_t before = than ? static_cast<std::uint32_t>(*than) + 1 : 0;
  if (wish_.load(std::memory_order_relaxed) == before) futex_wait(wish_, before, deadline);
  const std::uint32_t wish = wish_.load(std::memory_order_relaxed);
  if (wish == before || wish == 0) return std::nullopt;
  return static_cast<int>(wish - 1);
}

WorkCounts LensInUse::counts() const noexcept {
  WorkCounts sum = before_;
  const WorkCounts own = lens_->seeker.detector().counts();
  sum.runs_cut += own.runs_cut;
  sum.blobs_cut += own.blobs_cut;
  sum.neighbours_cut += own.neighbours_cut;
  sum.hypotheses_cut += own.hypotheses_cut;
  return sum;
}

LensInUse::Fit LensInUse::fit_to(const Frame& frame) noexcept {
  if (others_ == nullptr) return Fit::kSame;
  if (!(frame.zoom >= 0 && frame.zoom <= 0xFFFF)) return Fit::kNone;
  const auto zoom = static_cast<int>(std::lround(frame.zoom));
  if (lens_->zoom == zoom) return Fit::kSame;
  others_->ask(zoom);
  if (std::unique_ptr<Lens> fresh = others_->take()) {
    before_ = counts();
    std::swap(lens_, fresh);
    others_->give_back(std::move(fresh));
  }
  return lens_->zoom == zoom ? Fit::kAnother : Fit::kNone;
}

}  // namespace ninedot
