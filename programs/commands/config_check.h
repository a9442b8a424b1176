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

/// "NAME:LINE: what" of each: problems, or notes, which whoever shows them calls so.
std::vector<std::string> problem_lines(const std::vector<ConfigProblem>& problems, const std::string& name);

}  // namespace ninedot
