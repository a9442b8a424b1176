#pragma once
/// From what the board tells of itself to what registers say.
#include "drivers/posix/board_identity.h"
#include "proto/register_codec.h"

namespace ninedot {

/// \param board  of a longer serial number its end counts, where numbers differ
DeviceIdentity device_identity(const BoardIdentity& board);

}  // namespace ninedot
