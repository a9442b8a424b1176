// A calibration is refused with one line, or is finite and reads back to itself.
#include <cmath>

#include "base/contract.h"
#include "base/one_line.h"
#include "base/startup_error.h"
#include "calibrate/camera_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t count) {
  using namespace ninedot;
  CameraCalibration calibration;
  try {
    calibration = parse_calibration({reinterpret_cast<const char*>(bytes), count}, "camera.yaml");
  } catch (const StartupError& error) {
    const std::string line = error.what();
    EXPECTS(line.starts_with("camera.yaml:") && line.find('\n') == std::string::npos);
    return 0;
  }
  const CameraModel& camera = calibration.camera;
  const CalibrationRecord& record = calibration.record;
  for (const std::string& text : {record.date, record.camera_id, record.lens}) EXPECTS(one_line(text) == text);
  EXPECTS(record.date.empty() || record.date.size() == 10);
  EXPECTS(!record.views || *record.views >= 0);
  for (const auto& number : {record.rms_px, record.direction_sigma_px, record.direction_sigma_max_px})
    EXPECTS(!number || (std::isfinite(*number) && *number >= 0));
  EXPECTS(!record.covariance || (record.covariance->allFinite() && record.covariance->diagonal().minCoeff() >= 0 &&
                                 *record.covariance == record.covariance->transpose()));
  EXPECTS(std::isfinite(camera.fx_px) && camera.fx_px > 0 && std::isfinite(camera.cx_px) &&
          std::isfinite(camera.cy_px));
  const CameraModel again = parse_camera(format_camera(camera, "fuzz"), "again");
  EXPECTS(again.fx_px == camera.fx_px && again.cy_px == camera.cy_px && again.model == camera.model &&
          again.k == camera.k);
  return 0;
}
