#pragma once
/// The configured head, opened as the service opens it, with the thread that moves it.
#include <memory>
#include <string>

#include "config/config.h"
#include "geometry/camera_model.h"
#include "programs/assembly/open_source.h"
#include "programs/commands/toured_head.h"

namespace ninedot {

/// Not every head and camera can be held by one program only, so the service's port is asked.
/// Throws StartupError(kWorkFailed): a service runs, and has the head.
void check_no_service(const ModbusTcpConfig& tcp);

/// \param line  to a simulated camera's servos; null: it is none
/// \return  however it ends, the head is stopped then and left as the service leaves it
/// Throws StartupError(kWorkFailed): it can't be opened.
std::unique_ptr<TouredHead> open_own_head(const Config& config, const CameraModel& camera,
                                          const std::shared_ptr<HeadLine>& line);

}  // namespace ninedot
