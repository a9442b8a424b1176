#pragma once
/// What a calibration over a zoom has found, as a picture.
#include <string>
#include <vector>

namespace ninedot {

struct DrawnZoom {
  int zoom = 0;  ///< position [steps]
  double fx_px = 0, cx_px = 0, cy_px = 0;
};

struct ZoomDrawing {
  std::vector<DrawnZoom> calibrated;  ///< two or more, by rising position (contract)
  std::vector<DrawnZoom> between;     ///< of the curve, likewise; may be empty
  std::string title;
};

/// SVG text: focal length, logarithmic, and centre over the position.
std::string draw_zoom(const ZoomDrawing& drawing);

}  // namespace ninedot
