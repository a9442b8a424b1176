#pragma once
/// What is known of the time from row to row of a camera's shutter: from the configuration, and from pictures.
///
/// Every picture in which sheets move says something of it (world/row_time_equations.h). Where nobody has told what it
/// is, a Kalman filter of this one number learns it; where somebody has, the same filter runs beside, and what was told
/// counts until pictures contradict it beyond doubt, and again when they no longer do.
///
/// Most errors of pictures are no noise: a sheet that hangs a little aside, a camera that is slower in its track than
/// it is. The filter is never surer than what pictures have of those in common, and forgets slowly.
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
  /// What a row time that nobody has told counts as.
  enum class Untold : std::uint8_t {
    kIsOpen,
    kIsGlobal,  ///< 0, until pictures contradict it
  };
  /// \param told  by the configuration; none: nobody knows \param rows  of a picture, > 0 (contract)
  RowTimeBelief(const std::optional<std::chrono::nanoseconds>& told, int rows, Untold untold) noexcept;

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

  /// What pictures have said counts no more: they were held against another map.
  void forget_pictures() noexcept;

 private:
  bool take(const RowTimeEvidence& evidence) noexcept;

  const bool is_told_;  // by the configuration
  RowTime assumed_;     // told, or what counts as told; its sigma is that of the doubt
  bool is_assumed_believed_;
  RowTime seen_;
  double drift_ = 0;  // by how many of their sigmas the newest pictures are off from seen_, in the mean
  RowTime now_;
  double per_row_;  // 1 / rows
  bool is_told_by_frame_ = false;
};

}  // namespace ninedot
