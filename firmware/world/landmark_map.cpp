#include "world/landmark_map.h"

namespace ninedot {

Transform<frame::World, frame::Landmark> place_upright(const Eigen::Vector3d& position_m, double heading_rad) noexcept {
  return {exp_so3(heading_rad * Eigen::Vector3d::UnitZ()), position_m};
}

}  // namespace ninedot
