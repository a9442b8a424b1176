#include "programs/web/job_answers.h"

namespace ninedot {

MHD_Result send_made(MHD_Connection* connection, const std::string& file) {
  constexpr const char* kNoSuch = "Nothing of that name was made.\n";
  if (file.empty()) return send_text(connection, MHD_HTTP_NOT_FOUND, kNoSuch, kPlainText);
  return send_disk_file(connection, file, file.ends_with(".svg") ? "image/svg+xml" : kPlainText, kNoSuch);
}

}  // namespace ninedot
