#include "track/row_time_belief.h"

#include <algorithm>
#include <cmath>

#include "base/contract.h"

namespace ninedot {
namespace {

// Times of a whole picture, from its first row's exposure to its last one's.
// Of a camera of which nothing is known, 1-sigma: 16 ms are usual of small sensors, 33 the most at 30 Hz.
constexpr double kUnknown_s = 0.016;
// It is known: 15 % of that.
constexpr double kSeen_s = 2.4e-3;
// No picture says it better, whatever its noise.
constexpr double kOnePicture_s = 1e-3;
// Nor do all together: they share their lens and their prints.
constexpr double kAllPictures_s = 0.3e-3;
// What was learned is as much less certain after as many pictures that teach nothing: another map, another lens.
constexpr double kForgotten_s = 1e-3, kForgottenAfter = 1000;

// Shares. [1]
// Of what the row time is off by, what a picture may tell wrongly: its outlines were fitted with what was assumed, and
// sheared ones are read short.
constexpr double kReadShort = 0.3;
// Of the error of how fast the sheets are, and of prints and places, what consecutive pictures have in common.
constexpr double kCommonOfMotion = 0.3, kCommonOfUnexplained = 0.5;
// 1-sigma of the sheets' speed above which they say nothing: divided by a speed that is mostly noise, an answer lies
// near 0, by the square of the share.
constexpr double kMostMotion = 0.32;

// Thresholds [sigma]. What was told is doubted, and as uncertain as the pictures are far from it; it is wrong.
constexpr double kDoubted = 2.5, kContradicted = 6;
// Newest pictures whose answers lie, in units of their own sigmas, to one side by more in the mean than chance lets
// them (1 / sqrt(2 kNewest)): what was learned loses its weight with each of them.
constexpr double kNewest = 30;  // pictures
constexpr double kDrifted = 0.5, kUnlearned = 1.3;

double seconds(std::chrono::nanoseconds time) noexcept { return std::chrono::duration<double>(time).count(); }
double square(double x) noexcept { return x * x; }

}  // namespace

RowTimeBelief::RowTimeBelief(const std::optional<std::chrono::nanoseconds>& told, int rows, Untold untold) noexcept
    : is_told_(told.has_value()),
      assumed_{seconds(told.value_or(std::chrono::nanoseconds{0})), 0,
               told ? RowTimeSource::kTold : RowTimeSource::kOpen},
      is_assumed_believed_(is_told_ || untold == Untold::kIsGlobal),
      per_row_(1.0 / rows) {
  EXPECTS(rows > 0);
  forget_pictures();
  now_ = is_assumed_believed_ ? assumed_ : seen_;
}

void RowTimeBelief::forget_pictures() noexcept {
  seen_ = {assumed_.mean_s, kUnknown_s * per_row_, RowTimeSource::kOpen};
  drift_ = 0;
  is_assumed_believed_ |= is_told_;
  assumed_.sigma_s = 0;
}

const RowTime& RowTimeBelief::begin(const Frame& frame) noexcept {
  is_told_by_frame_ = frame.row_time.count() > 0;
  if (is_told_by_frame_)
    now_ = {seconds(frame.row_time), 0, RowTimeSource::kTold};
  else
    now_ = is_assumed_believed_ ? assumed_ : seen_;
  return now_;
}

/// \return  whether it said anything
bool RowTimeBelief::take(const RowTimeEvidence& evidence) noexcept {
  if (!(evidence.information_1_s2 > 0) || !(evidence.motion_share <= kMostMotion)) return false;
  const double answer_s = now_.mean_s + evidence.error_s;
  // Not of the answer alone: one near 0 would seem to be the most certain of all.
  const double most_s = std::max({std::abs(answer_s), std::abs(seen_.mean_s), seen_.sigma_s});
  const double by_motion_s2 = square(evidence.motion_share * most_s);
  const double picture_s2 = 1 / evidence.information_1_s2 + square(kOnePicture_s * per_row_) +
                            square(kReadShort * evidence.error_s) + by_motion_s2 + square(evidence.unexplained_s);
  if (!std::isfinite(picture_s2) || !std::isfinite(answer_s)) return false;
  const double all_s2 = square(kAllPictures_s * per_row_);
  double before_s2 = square(seen_.sigma_s) + square(kForgotten_s * per_row_) / kForgottenAfter;
  if (std::abs(drift_) > kDrifted) before_s2 *= kUnlearned;
  before_s2 = std::min(before_s2, square(kUnknown_s * per_row_));
  // What pictures have in common no number of them averages away: only what lies above it can be learned.
  const double common_s2 =
      square(kCommonOfMotion) * by_motion_s2 + square(kCommonOfUnexplained * evidence.unexplained_s);
  const double learnable_s2 = std::max(0.0, before_s2 - common_s2);
  const double gain = learnable_s2 / (learnable_s2 + picture_s2);
  seen_.mean_s += gain * (answer_s - seen_.mean_s);
  drift_ += ((answer_s - seen_.mean_s) / std::sqrt(before_s2 + picture_s2) - drift_) / kNewest;
  seen_.sigma_s = std::sqrt(std::max(all_s2, before_s2 - gain * learnable_s2));
  return true;
}

RowTimeBelief::News RowTimeBelief::learn(const RowTimeEvidence& evidence) noexcept {
  if (is_told_by_frame_ || !take(evidence)) return News::kNone;
  const double apart_s = std::abs(seen_.mean_s - assumed_.mean_s);
  if (!is_assumed_believed_) {
    // What was told, after all.
    if (is_told_ && seen_.source == RowTimeSource::kContradicted && apart_s < kDoubted * seen_.sigma_s) {
      is_assumed_believed_ = true;
      assumed_.sigma_s = 0;
      seen_.source = RowTimeSource::kOpen;
    }
    if (seen_.source == RowTimeSource::kOpen && seen_.sigma_s < kSeen_s * per_row_) seen_.source = RowTimeSource::kSeen;
    return News::kNone;
  }
  if (apart_s > kContradicted * seen_.sigma_s) {
    is_assumed_believed_ = false;
    seen_.source = is_told_ ? RowTimeSource::kContradicted : RowTimeSource::kSeen;
    return News::kContradicted;
  }
  const bool was_doubted = assumed_.sigma_s > 0;
  assumed_.sigma_s = apart_s > kDoubted * seen_.sigma_s ? apart_s : 0;
  return !was_doubted && assumed_.sigma_s > 0 ? News::kDoubted : News::kNone;
}

}  // namespace ninedot
