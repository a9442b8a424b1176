#pragma once
/// A made-up zoom lens, as lenses are: f from 500 to 5000 px (4 to 40 mm before pixels of 8 um), which grows faster
/// towards its long end, with a barrel's distortion that becomes a cushion's, and a centre that wanders.
#include <cmath>

#include "geometry/camera_model.h"

namespace ninedot::test {

inline constexpr int kZoomEnd = 1023;  ///< [steps]

/// \param zoom  0..kZoomEnd [steps] \param wobble  of the cams that move its groups: of ln f, rad of its phase
inline CameraModel zoom_lens(double zoom, double wobble = 0.01, double phase = 0) {
  const double u = zoom / kZoomEnd;
  CameraModel camera{640, 480, 0, 0, 0, 0, DistortionModel::kPlumbBob, {}};
  camera.fx_px = 500 * std::exp(1.75 * u - 0.35 * u * u + 0.9 * u * u * u + wobble * std::sin(5 * u + phase));
  camera.fy_px = 0.998 * camera.fx_px;
  camera.cx_px = 318 + 7 * u - 3 * std::sin(4 * u);
  camera.cy_px = 243 - 5 * u + 2 * std::cos(3 * u);
  const double f = camera.fx_px / 500;
  camera.k[0] = (-0.28 + 0.45 * u - 0.14 * u * u) * f * f;
  camera.k[1] = 0.08 * (1 - u) * (1 - u) * std::pow(f, 4);
  camera.k[2] = 0.0006 * f, camera.k[3] = -0.0004 * f;
  return camera;
}

}  // namespace ninedot::test
