#pragma once
/// Who looks on while the frame loop works: at each frame once its report is out and before its buffer goes back.
#include "image/frame.h"
#include "pipeline/frame_processor.h"
#include "report/report.h"

namespace ninedot {

class FrameObserver {
 public:
  virtual ~FrameObserver() = default;
  /// All of it is valid until this returns, the pixels too. The report has been published, so that nobody waits for
  /// this but the next frame. \param fix  what `by` made of the frame \param by  for what else there is to ask
  /// Memory: none. Threads: the frame loop's; must wait for nobody.
  virtual void observe(const Frame& frame, const Fix& fix, const FrameProcessor& by, const Report& report) noexcept = 0;
};

}  // namespace ninedot
