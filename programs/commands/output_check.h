#pragma once
/// Whether a command's results may go where they are told to.
#include <string>
#include <vector>

namespace ninedot {

struct NamedOutput {
  const char* option = "";  ///< as it is typed
  std::string path;         ///< empty: none; "-": standard output
};

/// Before the work, and before any output is opened. Throws StartupError(kWrongUsage) with one line: two outputs are
/// one file, or one of them is among what is read. \param inputs  files and recordings, as they were given; empty ones
/// count as none
void check_outputs(const std::vector<NamedOutput>& outputs, const std::vector<std::string>& inputs);

/// Likewise: an option that has to name a file names none.
void check_named(const NamedOutput& output);

}  // namespace ninedot
