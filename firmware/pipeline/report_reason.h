#pragma once
/// From an error on the frame path to the reason that reports give.
#include "base/reason.h"
#include "base/result.h"

namespace ninedot {

/// What an error means to those who read the reports; never kNone. Memory: none. Threads: pure.
Reason reason_of(Errc code) noexcept;

}  // namespace ninedot
