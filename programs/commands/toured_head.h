#pragma once
/// A head as whoever takes it along a tour sees it: its own servos, or the head of a running service.
#include <string>

#include "base/head_angles.h"
#include "image/frame.h"
#include "report/report.h"

namespace ninedot {

/// Threads: one.
class TouredHead {
 public:
  struct State {
    HeadAngles told;         ///< when the frame was exposed [rad]
    bool is_failed = false;  ///< it could not be moved, or does not answer
    bool is_inhibited = false;
    OrderProgress progress = OrderProgress::kNone;  ///< of the newest goal; kNone: it is not known yet
  };

  TouredHead() = default;
  TouredHead(const TouredHead&) = delete;
  TouredHead& operator=(const TouredHead&) = delete;
  /// No goal counts any more, and it is left as it was found.
  virtual ~TouredHead() = default;

  /// \param goal  within its limits [rad]; takes the place of the one before
  virtual void go(const HeadAngles& goal) = 0;
  virtual State state(const Frame& frame) = 0;
  /// Why something that belongs to it is not in use, for people. Empty: all is, as far as is known.
  virtual std::string problem() const { return {}; }
};

}  // namespace ninedot
