#include "pipeline/report_reason.h"

namespace ninedot {

Reason reason_of(Errc code) noexcept {
  switch (code) {
    case Errc::kEndOfStream:
      return Reason::kStopped;
    case Errc::kFrameSize:
      return Reason::kFrameSize;
    case Errc::kFrameUnreadable:
      return Reason::kFrameUnreadable;
    case Errc::kNoLandmark:
      return Reason::kNoLandmark;
    case Errc::kPoseDegenerate:
      return Reason::kPoseDegenerate;
    case Errc::kNoFrame:
    case Errc::kCameraLost:
    case Errc::kIo:
      break;
  }
  return Reason::kCameraLost;
}

}  // namespace ninedot
