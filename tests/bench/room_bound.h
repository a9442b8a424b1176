#pragma once
/// The Cramer-Rao bound of one picture of a room: the smallest error of the camera's place that all landmarks together
/// allow.
///
/// Each landmark's own bound (crlb.h) is a covariance of the camera's pose; with its place known exactly all are of the
/// same six unknowns, and independent: their inverses add up. Even light over each sheet, as bright as at its middle;
/// nothing moves. The camera measures luma alone, each pixel with the sensor's noise: what a Bayer pattern takes away
/// is no part of it.
#include <Eigen/Core>
#include <optional>
#include <span>

#include "tests/support/renderer.h"
#include "tests/support/room_wall.h"

namespace ninedot::bench {

/// A landmark of the room, as a scene of its own: the camera before it in its frame S0.
/// \param camera  in the world
test::Scene scene_of_landmark(const test::Room& room, const test::HungLandmark& landmark, const test::Lens& lens,
                              const test::Sensor& sensor, const test::CameraPose& camera);

/// 1 sigma of the camera's position, the three axes together [m]. \param shown  indices of the landmarks that count
/// \return  nothing where they do not determine a pose
std::optional<double> room_bound_m(const test::Room& room, std::span<const std::size_t> shown, const test::Lens& lens,
                                   const test::Sensor& sensor, const test::CameraPose& camera);

}  // namespace ninedot::bench
