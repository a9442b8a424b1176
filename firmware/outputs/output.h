#pragma once
/// What becomes of the reports: each thing that is done with them is one Output.
///
/// Outputs that may be late sit in the main thread's list; one that must answer each frame, or may be held up by a slow
/// line, has an OutputThread of its own. Neither can hold up the frame loop, nor each other's threads.
#include "report/report.h"

namespace ninedot {

class Output {
 public:
  virtual ~Output() = default;
  /// \param newest  one whole report \param is_new  there has been a newer one since the call before
  /// Threads: one, whichever drives it.
  virtual void take(const Report& newest, bool is_new, MonoTime now) = 0;
};

}  // namespace ninedot
