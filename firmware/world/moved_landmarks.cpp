#include "world/moved_landmarks.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/contract.h"

namespace ninedot {
namespace {

std::uint16_t raised(std::uint16_t frames, double beyond_chi2, double most_frames) noexcept {
  return static_cast<std::uint16_t>(std::clamp<double>(frames + std::ceil(beyond_chi2), 1, most_frames));
}

}  // namespace

MovedLandmarks::MovedLandmarks(std::size_t landmarks, int forgiven_after_frames)
    : to_agree_frames_(landmarks),
      disputed_frames_(landmarks),
      forgiven_after_frames_(static_cast<std::uint16_t>(forgiven_after_frames)) {
  EXPECTS(forgiven_after_frames >= 1 && forgiven_after_frames <= std::numeric_limits<std::uint16_t>::max());
}

bool MovedLandmarks::is_moved(std::size_t landmark) const noexcept {
  EXPECTS(landmark < to_agree_frames_.size());
  return to_agree_frames_[landmark] > 0;
}

void MovedLandmarks::disagrees(std::size_t landmark, double beyond_chi2) noexcept {
  EXPECTS(landmark < to_agree_frames_.size() && beyond_chi2 >= 0);
  // The one that was moved has been found.
  if (to_agree_frames_[landmark] == 0) std::ranges::fill(disputed_frames_, std::uint16_t{0});
  to_agree_frames_[landmark] = raised(to_agree_frames_[landmark], beyond_chi2, forgiven_after_frames_);
}

bool MovedLandmarks::is_disputed(std::size_t landmark) const noexcept {
  EXPECTS(landmark < disputed_frames_.size());
  return disputed_frames_[landmark] > 0;
}

std::size_t MovedLandmarks::disputed() const noexcept {
  return disputed_frames_.size() - static_cast<std::size_t>(std::ranges::count(disputed_frames_, std::uint16_t{0}));
}

void MovedLandmarks::dispute(std::size_t landmark, double beyond_chi2) noexcept {
  EXPECTS(landmark < disputed_frames_.size() && beyond_chi2 >= 0);
  disputed_frames_[landmark] = raised(disputed_frames_[landmark], beyond_chi2, kSettledAfter_frames);
}

void MovedLandmarks::agrees(std::size_t landmark) noexcept {
  EXPECTS(landmark < to_agree_frames_.size());
  if (to_agree_frames_[landmark] > 0) --to_agree_frames_[landmark];
  if (disputed_frames_[landmark] > 0) --disputed_frames_[landmark];
}

void MovedLandmarks::carry_over(const MovedLandmarks& before, std::size_t landmark_before,
                                std::size_t landmark) noexcept {
  EXPECTS(landmark_before < before.to_agree_frames_.size() && landmark < to_agree_frames_.size());
  to_agree_frames_[landmark] = before.to_agree_frames_[landmark_before];
  disputed_frames_[landmark] = before.disputed_frames_[landmark_before];
}

void MovedLandmarks::clear() noexcept {
  std::ranges::fill(to_agree_frames_, std::uint16_t{0});
  std::ranges::fill(disputed_frames_, std::uint16_t{0});
}

}  // namespace ninedot
