#pragma once
/// A new calibration of the pan/tilt head: `ninedot calibrate pan-tilt` writes sections of a configuration.
#include <string>

namespace ninedot {

/// The configuration with the keys of these sections in the place of its own; nothing else of it is touched.
/// \param name  of the sections' file, for errors
/// Throws StartupError(kWrongUsage) with one line: there are other keys in it than a calibration of a head has, or
/// none; or the configuration has a table that can't be edited. Memory: the texts a few times. Threads: pure.
std::string with_head(const std::string& config_text, const std::string& config_path, const std::string& head_text,
                      const std::string& name);

}  // namespace ninedot
