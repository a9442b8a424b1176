#pragma once
/// From one frame's fix to the report of it.
#include "pipeline/frame_processor.h"

namespace ninedot {

/// The report that follows `before`. When nothing was found its pose stays, with valid = false and the reason.
/// `published_at`, `latency` and the head's part are the frame loop's to fill. Memory: none. Threads: pure.
Report next_report(const Report& before, const Frame& frame, const Fix& fix) noexcept;

}  // namespace ninedot
