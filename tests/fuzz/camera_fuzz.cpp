/// Whatever a calibration file holds: it is refused with one line, or its model reads back from its own text.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "app/camera_file.h"
#include "base/contract.h"
#include "base/startup_error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace ninedot;
  try {
    const CameraModel camera = parse_camera(std::string_view(reinterpret_cast<const char*>(bytes), size), "fuzz.yaml");
    const CameraModel again = parse_camera(format_camera(camera, "fuzz"), "again.yaml");
    EXPECTS(again.width_px == camera.width_px && again.fx_px == camera.fx_px && again.k == camera.k);
  } catch (const StartupError& error) {
    EXPECTS(std::string_view(error.what()).find('\n') == std::string_view::npos);
  }
  return 0;
}
