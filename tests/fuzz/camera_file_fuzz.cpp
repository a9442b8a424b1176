// A calibration is refused with one line, or is finite and reads back to itself.
#include <cmath>

#include "base/contract.h"
#include "base/startup_error.h"
#include "calibrate/camera_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t count) {
  using namespace ninedot;
  CameraModel camera;
  try {
    camera = parse_camera({reinterpret_cast<const char*>(bytes), count}, "camera.yaml");
  } catch (const StartupError& error) {
    const std::string line = error.what();
    EXPECTS(line.starts_with("camera.yaml:") && line.find('\n') == std::string::npos);
    return 0;
  }
  EXPECTS(std::isfinite(camera.fx_px) && camera.fx_px > 0 && std::isfinite(camera.cx_px) &&
          std::isfinite(camera.cy_px));
  const CameraModel again = parse_camera(format_camera(camera, "fuzz"), "again");
  EXPECTS(again.fx_px == camera.fx_px && again.cy_px == camera.cy_px && again.model == camera.model &&
          again.k == camera.k);
  return 0;
}
