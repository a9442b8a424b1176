#pragma once
/// Whether a command's results may go where they are told to.
#include <string>
#include <vector>

#include "config/config.h"

namespace ninedot {

struct NamedOutput {
  const char* option = "";  ///< as it is typed
  std::string path;         ///< empty: none; "-": standard output
};

/// Before the work, and before any output is opened. Throws StartupError(kWrongUsage) with one line: two outputs are
/// one file or both standard output, or one of them is among what is read. \param outputs  files, and folders that get
/// pictures \param inputs  files and recordings, as they were given; empty ones count as none. A recording's
/// camera.yaml is one only where it is named by itself
void check_outputs(const std::vector<NamedOutput>& outputs, const std::vector<std::string>& inputs);

/// What a command reads beside a configuration because it says so: its map and its calibration. Memory: allocates.
std::vector<std::string> files_of(const Config& config);
/// The same, and the calibrations that recordings are looked at with. \param camera  of the command line, for all of
/// them; empty: each its own camera.yaml
std::vector<std::string> files_of(const Config& config, const std::vector<std::string>& recordings,
                                  const std::string& camera);

/// Likewise: an option that has to name a file names none.
void check_named(const NamedOutput& output);

}  // namespace ninedot
