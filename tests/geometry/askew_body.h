#pragma once
/// A head on a mast, a little askew everywhere.
#include "base/units.h"
#include "geometry/body.h"

namespace ninedot::test {

inline BodyGeometry askew_body() {
  BodyGeometry body;
  body.pan_axis_m = {0.2, -0.05, 0.9};
  body.mount_rpy_rad = Eigen::Vector3d(1.5, -2, 30) * kRadPerDeg;
  body.tilt_axis_m = {0.01, 0.002, 0.06};
  body.camera_m = {0.03, -0.004, 0.02};
  body.camera_rpy_rad = Eigen::Vector3d(0.5, -0.3, 0.8) * kRadPerDeg;
  return body;
}

}  // namespace ninedot::test
