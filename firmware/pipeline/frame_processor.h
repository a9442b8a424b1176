#pragma once
/// What the frame loop does with each frame.
#include <cstdint>

#include "base/mono_time.h"
#include "image/image_view.h"
#include "proto/report.h"

namespace ninedot {

class FrameProcessor {
 public:
  virtual ~FrameProcessor() = default;
  /// Turns the report of the frame before into this frame's; everything but `published_at` and `latency` is filled.
  /// When nothing is found the pose stays, with valid = false and the reason. Memory: none. Threads: one caller.
  virtual void process(const ImageView& luma, MonoTime exposed_at, std::uint64_t frame_number,
                       Report& report) noexcept = 0;
};

}  // namespace ninedot
