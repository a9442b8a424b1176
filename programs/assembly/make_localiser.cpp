#include "programs/assembly/make_localiser.h"

#include "pipeline/room_localiser.h"
#include "world/landmark_codes.h"

namespace ninedot {

std::unique_ptr<FrameProcessor> make_localiser(const CameraModel& camera, const LocaliserOptions& options) {
  const auto landmarks = options.map.landmarks();
  if (landmarks.size() == 1 && is_black_and_white(landmarks.front().code))
    return std::make_unique<Localiser>(camera, options);
  return std::make_unique<RoomLocaliser>(camera, options);
}

}  // namespace ninedot
