#pragma once
/// A wall with three coded sheets, for rooms of moving cameras.
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/room_renderer.h"
#include "world/landmark_codes.h"
#include "world/landmark_map.h"

namespace ninedot::test {

/// Hangs them into the room, upright on the wall at high X. \return  where they are
inline LandmarkMap hang_three_sheets(Room& room, const std::array<double, 3>& along_m,
                                     const std::array<double, 3>& height_m) {
  room.wall = {0.4, 0.1, 0.1, 7};
  std::vector<MappedLandmark> landmarks;
  for (std::size_t i = 0; i < along_m.size(); ++i) {
    const int id = static_cast<int>(i) + 1;
    const std::string code(known_code(id).value());
    const HungLandmark hung{RoomSide::kHighX, along_m[i], height_m[i], inks_of_code(code)};
    room.landmarks.push_back(hung);
    const Eigen::Vector3d x0 = axes_of(hung.side).col(0);
    landmarks.push_back(
        {static_cast<std::uint16_t>(id), code, place_upright(place_of(room, hung), std::atan2(x0.y(), x0.x()))});
  }
  return LandmarkMap(std::move(landmarks));
}

}  // namespace ninedot::test
