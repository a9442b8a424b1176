#pragma once
/// All that `ninedot check` looks at, for it and for `ninedot apply`.
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "config/config_checks.h"
#include "geometry/camera_model.h"
#include "programs/assembly/config_findings.h"

namespace ninedot {

/// Asks the same functions as the service; ports and serial lines are only looked at, because a running service may be
/// using them. \param config, problems  as read_config gave them \param camera  set where a calibration was read
/// Memory: a camera's buffers for a moment. Threads: one; may wait for devices.
void check_as_the_service(const Config& config, const ConfigProblems& problems, ConfigFindings& findings,
                          std::optional<CameraModel>& camera);

/// Its problems as lines "NAME:LINE: what", or its notes as lines "NAME:LINE: note: what".
std::vector<std::string> problem_lines(const ConfigFindings& findings, const std::string& name);
std::vector<std::string> note_lines(const ConfigFindings& findings, const std::string& name);

}  // namespace ninedot
