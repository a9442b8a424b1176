#pragma once
/// Where a pan/tilt head points.

namespace ninedot {

/// Pan is positive to the left, tilt positive upwards, both zero straight ahead. Panning turns the tilt axis with it.
struct HeadAngles {
  double pan_rad = 0, tilt_rad = 0;

  bool operator==(const HeadAngles&) const = default;
};

}  // namespace ninedot
