#pragma once
/// What is wrong with a device node, for people.
#include <string>

namespace ninedot {

/// No such device, permission (and which group has it), busy: one line that says what to do. \param error  errno
std::string describe_open_failure(const std::string& path, int error);

}  // namespace ninedot
