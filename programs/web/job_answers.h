#pragma once
/// What is answered where `ninedot` works for the page, under /api/calibrate and /api/map/build:
///
///     GET  /api/calibrate                   how the newest calibration fares, and whether one may begin
///     GET  /api/calibrate/NAME/camera.yaml  what one made; camera.svg: its picture; head.toml: of a head
///     POST /api/calibrate                   "start camera", "start pan-tilt", "finish", "cancel", "use NAME"
///     GET  /api/map/build                   how the newest map fares, and whether one may be built
///     GET  /api/map/build/NAME/map.toml     what was made; plan.svg: its picture
///     POST /api/map/build                   "start ORIGIN NAME ...", "cancel", "use NAME"
#include "programs/web/apply_request.h"
#include "programs/web/http_answer.h"

namespace ninedot {

inline constexpr std::string_view kCalibratePath = "/api/calibrate", kBuildMapPath = "/api/map/build";

/// \param root  kCalibratePath or kBuildMapPath
inline bool is_below(std::string_view path, std::string_view root) noexcept {
  return path.starts_with(root) && (path.size() == root.size() || path[root.size()] == '/');
}

/// A file that was made. \param file  empty: there is none
MHD_Result send_made(MHD_Connection* connection, const std::string& file);

/// \param desk  CalibrationDesk, MapDesk \param head  of a path that is_below `root` \param body  of a POST; lifetime:
/// until it is answered
template <typename Desk>
MHD_Result answer_job(MHD_Connection* connection, const RequestHead& head, std::string_view root, std::string_view body,
                      Desk& desk) {
  if (head.method == "POST") {
    const DeskReply reply = desk.reply_to(body);
    return send_text(connection, reply.status, reply.text, reply.status < 300 ? kJsonText : kPlainText);
  }
  if (head.path == root) return send_text(connection, MHD_HTTP_OK, desk.state_json(), kJsonText);
  return send_made(connection, desk.file_of(head.path.substr(root.size() + 1)));
}

}  // namespace ninedot
