#pragma once
/// What the status LED tells someone who stands in front of the cabinet.
#include "base/mono_time.h"
#include "report/report.h"

namespace ninedot {

/// The patterns, two seconds long each:
///   tracking     lit
///   no landmark  lit for half of each second: none in sight, or none whose pose may be acted on
///   no camera    two short flashes
///   fault        five flashes a second: frames that can't be used, a head that does not answer, or the end of the
///   source
enum class LedPattern { kTracking, kNoLandmark, kNoCamera, kFault };

LedPattern led_pattern_of(const Report& report) noexcept;
bool is_led_lit(LedPattern pattern, MonoTime now) noexcept;

}  // namespace ninedot
