#include "aim/landmark_chooser.h"

#include <algorithm>

#include "base/contract.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

// As long as the current one is missed no longer, none takes its place: ten frames, a person who walks past it.
constexpr auto kMissed = 300ms;
// So long the next one must have been nearer.
constexpr auto kHandsOver = 300ms;
// What distances are uncertain by: two landmarks equally far must not take turns.
constexpr double kEquallyFar = 0.02;

const AimSight* find(std::span<const AimSight> sights, std::uint16_t id) noexcept {
  const auto found = std::ranges::find(sights, id, &AimSight::id);
  return found != sights.end() ? &*found : nullptr;
}

double distance_m(const AimSight& sight) noexcept { return sight.landmark_camera_m.norm(); }

}  // namespace

LandmarkChooser::LandmarkChooser(const AimOptions& options) noexcept
    : choice_(options.landmark),
      wanted_(options.landmark_id),
      margin_(options.landmark == LandmarkChoice::kNearest ? kEquallyFar : options.hand_over_margin) {
  EXPECTS(options.hand_over_margin >= 0 && options.hand_over_margin < 1);
}

const AimSight* LandmarkChooser::change_to(const AimSight& sight) noexcept {
  current_ = sight.id;
  seen_at_ = sight.exposed_at;
  nearer_.reset();
  return &sight;
}

const AimSight* LandmarkChooser::choose(std::span<const AimSight> sights) noexcept {
  if (choice_ == LandmarkChoice::kById) return find(sights, wanted_);
  if (sights.empty()) return nullptr;
  if (choice_ == LandmarkChoice::kReported) return &sights.front();

  const AimSight& nearest = *std::ranges::min_element(sights, {}, distance_m);
  const AimSight* const same = current_ ? find(sights, *current_) : nullptr;
  if (same == nullptr) return !current_ || nearest.exposed_at - seen_at_ > kMissed ? change_to(nearest) : nullptr;
  seen_at_ = same->exposed_at;
  if (distance_m(nearest) >= (1 - margin_) * distance_m(*same)) {
    nearer_.reset();
    return same;
  }
  if (choice_ == LandmarkChoice::kNearest) return change_to(nearest);
  if (nearer_ != nearest.id) {
    nearer_ = nearest.id;
    nearer_since_ = nearest.exposed_at;
  }
  return nearest.exposed_at - nearer_since_ >= kHandsOver ? change_to(nearest) : same;
}

}  // namespace ninedot
