#pragma once
/// A head that is known exactly, and what its camera sees of landmarks: dots by projection, with noise as large as they
/// say.
#include <cstdint>
#include <vector>

#include "calibrate_head/head_stops.h"
#include "geometry/body.h"

namespace ninedot::test {

/// How an axis's true angle follows from the one that it is told.
struct MadeUpAxis {
  double scale = 1, offset_rad = 0;        ///< true = offset + scale told + bend sin(told / 0.25 rad)
  double bend_rad = 0;                     ///< amplitude
  double play_rad = 0, spread_rad = 0;     ///< end to end; 1-sigma
  double from_rad = -0.45, to_rad = 0.45;  ///< told
  int stops = 7;

  double true_rad(double told_rad) const;
};

struct MadeUpHeadOptions {
  BodyGeometry body{};  ///< from the foot on
  double skew_rad = 0;
  MadeUpAxis pan, tilt{.from_rad = -0.25, .to_rad = 0.25, .stops = 5};
  int landmarks = 1;
  double distance_m = 1.0, noise_px = 0.02;
  std::uint64_t seed = 1;
  std::size_t moved_after = 1000;     ///< stops, after which the landmark hangs 60 mm beside
  std::size_t slips_every = 1000;     ///< at each such stop the pan axis is 3 deg off
  std::size_t mirrored_every = 1000;  ///< at each such stop the sighting's own pose is the mirror image
};

inline constexpr double kMadeUpFocalLength_px = 700;

/// Twice through the grid of both axes' stops, to and fro, so that each is come to from both sides.
std::vector<HeadStop> made_up_stops(const MadeUpHeadOptions& options);

/// One landmark of the default size before the camera. \param noise_px  of each dot
LandmarkSighting made_up_sighting(const CameraFromLandmark& T_camera_landmark, double noise_px, std::uint64_t seed);

}  // namespace ninedot::test
