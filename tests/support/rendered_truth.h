#pragma once
/// What a renderer was told, in the product's own types.
#include <Eigen/Geometry>

#include "geometry/camera_model.h"
#include "geometry/transform.h"
#include "tests/support/room_renderer.h"

namespace ninedot::test {

/// Of a lens without distortion.
inline CameraModel pinhole_of(const Lens& lens) {
  CameraModel camera;
  camera.fx_px = lens.fx_px, camera.fy_px = lens.fy_px, camera.cx_px = lens.cx_px, camera.cy_px = lens.cy_px;
  camera.width_px = lens.width_px, camera.height_px = lens.height_px;
  return camera;
}

inline CameraFromLandmark sheet_before(const CameraPose& pose) {
  const auto& q = pose.quaternion_wxyz;
  const auto& p = pose.position_m;
  const Transform<frame::Landmark, frame::Camera> T_landmark_camera{
      Eigen::Quaterniond(q[0], q[1], q[2], q[3]).toRotationMatrix(), {p[0], p[1], p[2]}};
  return T_landmark_camera.inverse();
}

/// A hall with one sheet on its wall, where the landmark's own frame is the room's.
inline Room hall_with_sheet(const char* code) {
  Room room;
  room.low_m = {-30, 0, -30}, room.high_m = {30, 30, 30};
  room.landmarks = {{RoomSide::kLowY, 0, 0, inks_of_code(code), {0.9, 0.9, 0.9}}};
  return room;
}

}  // namespace ninedot::test
