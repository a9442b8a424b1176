#include "programs/web/calibration_answers.h"

namespace ninedot {

MHD_Result answer_calibration(MHD_Connection* connection, const RequestHead& head, std::string_view body,
                              CalibrationDesk& desk) {
  constexpr const char* kNoSuch = "There is no such calibration.\n";
  if (head.method == "POST") {
    const DeskReply reply = desk.reply_to(body);
    return send_text(connection, reply.status, reply.text, reply.status < 300 ? kJsonText : kPlainText);
  }
  if (head.path == kCalibratePath) return send_text(connection, MHD_HTTP_OK, desk.state_json(), kJsonText);
  const std::string file = desk.file_of(head.path.substr(kCalibratePath.size() + 1));
  if (file.empty()) return send_text(connection, MHD_HTTP_NOT_FOUND, kNoSuch, kPlainText);
  return send_disk_file(connection, file, file.ends_with(".svg") ? "image/svg+xml" : kPlainText, kNoSuch);
}

}  // namespace ninedot
