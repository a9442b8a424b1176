#pragma once
/// Where landmarks hang in the world.
#include <Eigen/Core>

#include "geometry/transform.h"

namespace ninedot {

/// The place of a landmark that hangs upright: its P9 at `position_m` [m, world], turned by `heading_rad` about the
/// world's Z (positive from X towards Y). Heading 0: the axes of S0 are those of the world, the sheet looks along +Y.
/// Memory: none. Threads: pure.
Transform<frame::World, frame::Landmark> place_upright(const Eigen::Vector3d& position_m, double heading_rad) noexcept;

}  // namespace ninedot
