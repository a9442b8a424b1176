#pragma once
/// The set-points of a head that is jogged: a short way ahead of it at most, so that nothing is left to do for it once
/// no more of them come, not even when whoever sends them has died.
#include <chrono>

#include "programs/web/aim_request.h"

namespace ninedot {

/// Angles of the head. Pan is positive to the left, tilt positive upwards.
struct HeadDegrees {
  double pan_deg = 0, tilt_deg = 0;  ///< [deg]
  bool operator==(const HeadDegrees&) const = default;
};

struct JogAxis {
  double min_deg = -45, max_deg = 45;  ///< min <= max (contract)
  double fastest_deg_s = 10;           ///< [deg/s]; whatever is asked for
};

/// Memory: inside. Threads: one.
class JogPath {
 public:
  /// No jog is faster, whatever the head could: 200 ms of it are 6 deg.
  static constexpr double kFastest_deg_s = 30;
  /// How far the set-point may be ahead of where the head was last reported: what it turns in this time, for commands
  /// take effect, and reports arrive, some tens of milliseconds late; and its dead band.
  static constexpr std::chrono::milliseconds kLead{250};
  static constexpr double kPlay_deg = 0.5;
  /// One step is never longer, however late it comes.
  static constexpr std::chrono::milliseconds kLongestStep{40};

  JogPath(const JogAxis& pan, const JogAxis& tilt);

  /// From here on, at rest.
  void stand(const HeadDegrees& at) noexcept;
  /// One step at these speeds. \param reported  where the head is, as far as it is known
  /// \return  where it is to go: within the limits
  HeadDegrees advance(const JogRates& rates, const HeadDegrees& reported, std::chrono::nanoseconds step) noexcept;
  const HeadDegrees& set_point() const noexcept { return at_; }

 private:
  JogAxis pan_, tilt_;
  HeadDegrees at_;
};

}  // namespace ninedot
