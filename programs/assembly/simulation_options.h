#pragma once
/// From [simulation], [body], [[landmarks]] and [camera] of the configuration to the simulated camera and its head.
#include <cstdint>

#include "config/config.h"
#include "drivers/simulation/simulated_camera.h"
#include "geometry/camera_model.h"

namespace ninedot {

/// The camera where no calibration is named: 48 deg wide, without distortion, of the configured size.
CameraModel default_simulated_camera(const CameraConfig& config);

/// \param seed  of the noise
/// Throws StartupError(kWrongUsage): there is no robot, or no landmark with a place.
SimulationOptions simulation_options(const Config& config, const CameraModel& camera, std::uint64_t seed);

/// The clock of simulations in real time.
SimulationClock& machine_clock();

}  // namespace ninedot
