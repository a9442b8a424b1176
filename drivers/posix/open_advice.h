#pragma once
/// What to do about a file or device that could not be opened.
#include <string>

namespace ninedot {

/// One line: what `error` means for `path`, and what to do; for a missing permission which group to join.
/// \param error  an errno
/// Memory: allocates. Threads: one at a time (getgrgid); asks the user database, which may wait.
std::string open_advice(const std::string& path, int error);

}  // namespace ninedot
