#pragma once
/// What people are told of a camera's rolling shutter.
#include <string>

#include "base/row_time.h"

namespace ninedot {

/// One line, once pictures have shown what the configuration does not say, or that it is wrong. Empty: there is nothing
/// to say.
std::string row_time_text(const RowTime& rows);

}  // namespace ninedot
