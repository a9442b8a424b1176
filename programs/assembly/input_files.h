#pragma once
/// The files that a program starts from.
#include <cstddef>
#include <string>
#include <string_view>

#include "calibrate/camera_file.h"
#include "config/config_checks.h"

namespace ninedot {

/// Far beyond any configuration or calibration that a person writes: another file was named by mistake.
inline constexpr std::size_t kMaxFile_bytes = std::size_t{1} << 20U;

/// Reads and checks a configuration file.
/// Throws StartupError(kWrongUsage) with "FILE:LINE: what is wrong and what to write instead".
/// Relative paths (`calibration`, `map`, a recording's `device`, those of [tap] and [web]) come back as seen from the
/// folder of the file; the landmarks of a `map` are read from there, and its mistakes are told with its name and line.
Config read_config(const std::string& path);

/// The same, which tells all that is wrong, and where the keys stand. \param problems  as read_config_text
/// Throws StartupError(kWrongUsage): the file can't be read.
Config read_config(const std::string& path, ConfigProblems& problems);

/// The same of text that is to become the file `path`. \param name  how errors call it
/// \param map  a file that is read in the place of the map's, as whoever names it sees it from where the program was
/// started; empty: the map's
/// Memory: in proportion to the text.
Config read_config(std::string_view text, const std::string& name, const std::string& path, ConfigProblems& problems,
                   const std::string& map = {});

/// Throws StartupError(kWrongUsage) with the first of them, if there is one. \param path  of the configuration
void refuse_first(const ConfigProblems& problems, const std::string& path);

/// Reads and checks the file that config.map names into config.landmarks; everything else stays. What is wrong is added
/// to `problems`, which knows the lines of the configuration.
void read_map(Config& config, ConfigProblems& problems);

/// Reads and checks a calibration. Throws StartupError(kWrongUsage), "FILE:LINE: what is wrong".
CameraCalibration read_calibration_file(const std::string& path);

/// The camera of it alone. Throws StartupError(kWrongUsage), "FILE:LINE: what is wrong".
CameraModel read_camera_file(const std::string& path);

}  // namespace ninedot
