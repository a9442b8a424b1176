#include "programs/web/configuration_answers.h"

#include <string>

namespace ninedot {

MHD_Result answer_configuration(MHD_Connection* connection, const RequestHead& head, std::string_view body,
                                ConfigurationDesk& desk, bool has_token) {
  const auto json = [&](const std::string& text) { return send_text(connection, MHD_HTTP_OK, text, kJsonText); };
  const std::string_view what = head.path.substr(kConfigurationPath.size());
  if (head.method == "POST" && what == "/check") return json(desk.check_json(body));
  if (head.method == "POST" && what == "/apply") {
    const DeskReply reply = desk.apply(body, header_of(connection, "If-Match"), has_token);
    return send_text(connection, reply.status, reply.text, reply.status == 202 ? kJsonText : kPlainText);
  }
  if (what.empty()) return json(desk.file_json(has_token));
  if (what == "/apply") return json(desk.apply_json());
  if (what == "/keys") {
    static const std::string keys = configuration_keys_json();
    return json(keys);
  }
  return send_text(connection, MHD_HTTP_NOT_FOUND, "There is no such page.\n", kPlainText);
}

}  // namespace ninedot
