#pragma once
/// What is known of the time from row to row of a camera's shutter: from the configuration, and from pictures.
///
/// Every picture in which sheets move says something of it (world/row_time_equations.h). Where nobody has told what it
/// is, a Kalman filter of this one number learns it; where somebody has, the same filter runs beside, and what was told
/// counts until pictures contradict it beyond doubt.
#include <chrono>
#include <cstdint>
#include <optional>

#include "base/row_time.h"
#include "image/frame.h"
#include "world/row_time_equations.h"

namespace ninedot {

/// Memory: none beyond itself. Threads: one caller.
class RowTimeBelief {
 public:
  /// \param told  by the configuration; none: nobody knows \param rows  of a picture, > 0 (contract)
  RowTimeBelief(const std::optional<std::chrono::nanoseconds>& told, int rows) noexcept;

  /// A frame that is to be looked at. \return  what to take its rows for; so does `now`, until the next one
  const RowTime& begin(const Frame& frame) noexcept;
  const RowTime& now() const noexcept { return now_; }

  enum class News : std::uint8_t {
    kNone,
    kDoubted,       ///< from this frame on it is doubted what was told
    kContradicted,  ///< from this frame on it is known to be wrong: so is what was made of it
  };
  /// By the frame under way, whose dots were taken to the middle row with `now`. Frames that tell it themselves teach
  /// nothing.
  News learn(const RowTimeEvidence& evidence) noexcept;

 private:
  RowTime told_, seen_, now_;
  double per_row_;  // 1 / rows
  bool is_told_by_frame_ = false;
};

}  // namespace ninedot
