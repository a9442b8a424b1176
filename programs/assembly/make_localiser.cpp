#include "programs/assembly/make_localiser.h"

#include "pipeline/room_localiser.h"
#include "world/landmark_codes.h"

namespace ninedot {

bool is_room(const LandmarkMap& map) noexcept {
  return map.landmarks().size() > 1 || !is_black_and_white(map.landmarks().front().code);
}

std::unique_ptr<FrameProcessor> make_localiser(const CameraModel& camera, const LocaliserOptions& options) {
  if (is_room(options.map)) return std::make_unique<RoomLocaliser>(camera, options);
  return std::make_unique<Localiser>(camera, options);
}

}  // namespace ninedot
