#include "track/row_time_belief.h"

#include <algorithm>
#include <cmath>

#include "base/contract.h"

namespace ninedot {
namespace {

// Times of a whole picture, from its first row's exposure to its last one's.
// Of a camera of which nothing is known, 1-sigma: 16 ms are usual of small sensors, 33 the most at 30 Hz.
constexpr double kUnknown_s = 0.016;
// It is known: 5 % of that.
constexpr double kSeen_s = 0.8e-3;
// No picture says it better, whatever its noise: how fast its sheets were is a forecast.
constexpr double kOnePicture_s = 1e-3;
// Nor do all together: they share their map, their lens and their prints.
constexpr double kAllPictures_s = 0.3e-3;
// Of what the row time is off by, the share that a picture may tell wrongly: its outlines were fitted with what was
// assumed, and sheared ones are read short. [1]
constexpr double kReadShort = 0.3;
// Of the error of how fast the sheets are, what consecutive pictures have in common: a camera that goes on gaining speed
// is slower in its track than it is. [1]
constexpr double kCommonOfMotion = 0.3;
// What was told is doubted, and as uncertain as the pictures are far from it; is wrong beyond doubt. [sigma] Each
// second is another chance: beyond three sigmas by mere chance it lies for a second in six minutes, beyond six in 16
// years.
constexpr double kDoubted = 3, kContradicted = 6;
// Nor is it what a warped sheet may look like. [sigma]
constexpr double kUnexplained = 3;

double seconds(std::chrono::nanoseconds time) noexcept { return std::chrono::duration<double>(time).count(); }

}  // namespace

RowTimeBelief::RowTimeBelief(const std::optional<std::chrono::nanoseconds>& told, int rows) noexcept
    : told_{seconds(told.value_or(std::chrono::nanoseconds{0})), 0, told ? RowTimeSource::kTold : RowTimeSource::kOpen},
      seen_{told_.mean_s, kUnknown_s / rows, RowTimeSource::kOpen},
      now_(told ? told_ : seen_),
      per_row_(1.0 / rows) {
  EXPECTS(rows > 0);
}

const RowTime& RowTimeBelief::begin(const Frame& frame) noexcept {
  is_told_by_frame_ = frame.row_time.count() > 0;
  if (is_told_by_frame_)
    now_ = {seconds(frame.row_time), 0, RowTimeSource::kTold};
  else
    now_ = told_.source == RowTimeSource::kTold ? told_ : seen_;
  return now_;
}

RowTimeBelief::News RowTimeBelief::learn(const RowTimeEvidence& evidence) noexcept {
  if (is_told_by_frame_ || !(evidence.information_1_s2 > 0)) return News::kNone;
  const double one_s = kOnePicture_s * per_row_, read_short_s = kReadShort * evidence.error_s;
  const double by_motion_s = evidence.motion_share * (now_.mean_s + evidence.error_s);
  const double picture_s2 =
      1 / evidence.information_1_s2 + one_s * one_s + read_short_s * read_short_s + by_motion_s * by_motion_s;
  // What the speeds have in common no number of pictures averages away: only what lies above it can be learned.
  const double common_s = kCommonOfMotion * by_motion_s;
  const double before_s2 = std::max(0.0, seen_.sigma_s * seen_.sigma_s - common_s * common_s);
  const double gain = before_s2 / (before_s2 + picture_s2);
  seen_.mean_s += gain * (now_.mean_s + evidence.error_s - seen_.mean_s);
  seen_.sigma_s = std::max(kAllPictures_s * per_row_, std::sqrt(seen_.sigma_s * seen_.sigma_s - gain * before_s2));
  if (seen_.source == RowTimeSource::kOpen && seen_.sigma_s < kSeen_s * per_row_) seen_.source = RowTimeSource::kSeen;
  if (told_.source != RowTimeSource::kTold) return News::kNone;
  const double apart_s = std::abs(seen_.mean_s - told_.mean_s);
  if (apart_s > std::max(kContradicted * seen_.sigma_s, kUnexplained * evidence.unexplained_s)) {
    told_.source = seen_.source = RowTimeSource::kContradicted;
    return News::kContradicted;
  }
  const bool was_doubted = told_.sigma_s > 0;
  told_.sigma_s = apart_s > kDoubted * seen_.sigma_s ? apart_s : 0;
  return !was_doubted && told_.sigma_s > 0 ? News::kDoubted : News::kNone;
}

}  // namespace ninedot
