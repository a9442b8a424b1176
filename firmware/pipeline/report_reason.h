#pragma once
/// From an error on the frame path to a report that says so.
#include "base/result.h"
#include "proto/report.h"

namespace ninedot {

/// What an error means to those who read the reports.
Reason reason_of(Errc code) noexcept;

/// Marks a report as not valid: its pose stays, everything that calls it fresh goes.
void mark_invalid(Reason reason, Report& report) noexcept;

}  // namespace ninedot
