#pragma once
/// What a pose that is followed from one frame to the next has to be like.
#include <optional>

#include "pose/estimate.h"

namespace ninedot {

/// Memory: none. Threads: const is safe.
struct PoseExpectation {
  CameraFromLandmark T_camera_landmark;  ///< of the sheet in this picture; its outlines within about half a pixel
  std::optional<PoseEstimate> before;    ///< of the frame before; none: whatever is there will do

  /// Fewer dots: something has come before the sheet, or it is another one. No other light brings them back.
  bool lacks_dots(const PoseCandidate& followed) const noexcept;

  /// As many dots, as good a fit, as certain, and turned as expected; where it is in the picture who follows it has
  /// asked.
  bool includes(const PoseCandidate& followed) const noexcept;
};

}  // namespace ninedot
