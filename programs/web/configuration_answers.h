#pragma once
/// What is answered under /api/configuration:
///
///     GET  /api/configuration         the file, the one before, what may be done, the newest apply
///     GET  /api/configuration/apply   the newest apply
///     GET  /api/configuration/keys    every key with its meaning
///     POST /api/configuration/check   a text -> its messages by line
///     POST /api/configuration/apply   a text, with If-Match: the tag of the file that it was made from
#include "programs/web/configuration_desk.h"
#include "programs/web/http_answer.h"

namespace ninedot {

inline constexpr std::string_view kConfigurationPath = "/api/configuration";

/// \param body  of a POST; lifetime: until it is answered
MHD_Result answer_configuration(MHD_Connection* connection, const RequestHead& head, std::string_view body,
                                ConfigurationDesk& desk, bool has_token);

}  // namespace ninedot
