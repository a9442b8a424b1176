#pragma once
/// Pictures of coloured landmarks in a room, by a camera that moves while it exposes: motion blur and rolling shutter.
///
/// The same light, outlines, point spread and Bayer pattern as renderer.h and colour_renderer.h; a room of one wall and
/// a camera at rest give the same bytes as they do. As there, nothing is shared with the estimator's projection.
///
/// A camera's pose is its optical centre in the world and the quaternion that rotates camera vectors into it.
#include <Eigen/Core>
#include <functional>
#include <vector>

#include "tests/support/colour_renderer.h"
#include "tests/support/renderer.h"
#include "tests/support/room_wall.h"

namespace ninedot::test {

/// The camera's pose `after_s` after the middle of the middle row's exposure.
using CameraWay = std::function<CameraPose(double after_s)>;

/// Each row is exposed for `exposure_s`, its middle `row_time_s` later than that of the row above.
struct Shutter {
  double exposure_s = 0;
  double row_time_s = 0;
  /// The light is the mean of so many pictures, of one where exposure_s is 0. A pixel of motion each, or less.
  int sub_exposures = 8;
};

/// Memory: the rays of all pixels, the pattern of the walls. Threads: const is safe.
class RoomRenderer {
 public:
  /// \param lens  sees something at each pixel and a few beyond (contract)
  RoomRenderer(const Room& room, const Lens& lens, const Sensor& sensor);

  /// Noise not yet. \param way  inside of the room (contract)
  ColourExposure expose(const CameraWay& way, const Shutter& shutter) const;

  /// What a row of pixels looks along, in the world.
  struct Row {
    Eigen::Vector3d centre_m;
    std::vector<Eigen::Vector3d> directions;
  };

 private:
  void read_row(int row, const CameraPose& pose, Row& out) const;

  Lens lens_;
  double point_spread_px_;
  int margin_px_;
  std::vector<Eigen::Vector3d> rays_;  ///< camera frame; with the margin and one more row and column for derivatives
  Eigen::Vector3d low_m_, high_m_;
  std::vector<RoomWall> walls_;  ///< at the ends of X, Y and Z, each low then high
};

}  // namespace ninedot::test
