#pragma once
/// Small text files, read at start-up.
#include <cstddef>
#include <string>

namespace ninedot {

/// The whole file. Throws StartupError(kWrongUsage), one line: it can't be opened or read, or is longer than
/// `max_bytes`. Threads: any; waits for the disk.
std::string read_text_file(const std::string& path, std::size_t max_bytes);

}  // namespace ninedot
