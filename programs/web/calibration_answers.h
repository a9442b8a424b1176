#pragma once
/// What is answered under /api/calibrate:
///
///     GET  /api/calibrate                   how the newest calibration fares, and whether one may begin
///     GET  /api/calibrate/NAME/camera.yaml  what one made; camera.svg: its picture; head.toml: of a head
///     POST /api/calibrate                   "start camera", "start pan-tilt", "finish", "cancel", "use NAME"
#include "programs/web/calibration_desk.h"
#include "programs/web/http_answer.h"

namespace ninedot {

inline constexpr std::string_view kCalibratePath = "/api/calibrate";

inline bool is_of_calibration(std::string_view path) noexcept {
  return path == kCalibratePath || (path.starts_with(kCalibratePath) && path[kCalibratePath.size()] == '/');
}

/// \param head  of a path that is_of_calibration \param body  of a POST; lifetime: until it is answered
MHD_Result answer_calibration(MHD_Connection* connection, const RequestHead& head, std::string_view body,
                              CalibrationDesk& desk);

}  // namespace ninedot
