#include "programs/web/http_answer.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <array>
#include <string>

#include "drivers/posix/file_descriptor.h"

namespace ninedot {
namespace {

// Nothing from outside, nothing inline, in no frame.
constexpr const char* kContentPolicy =
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob:; connect-src 'self'; base-uri "
    "'none'; "
    "form-action 'none'; frame-ancestors 'none'";

std::string text_of(const sockaddr* address) {
  std::array<char, INET6_ADDRSTRLEN> text{};
  if (address != nullptr && address->sa_family == AF_INET)
    ::inet_ntop(AF_INET, &reinterpret_cast<const sockaddr_in*>(address)->sin_addr, text.data(), text.size());
  if (address != nullptr && address->sa_family == AF_INET6)
    ::inet_ntop(AF_INET6, &reinterpret_cast<const sockaddr_in6*>(address)->sin6_addr, text.data(), text.size());
  return text.data();
}

std::string_view value_of(MHD_Connection* connection, MHD_ValueKind kind, const char* name) {
  const char* const value = MHD_lookup_connection_value(connection, kind, name);
  return value == nullptr ? std::string_view() : std::string_view(value);
}

}  // namespace

std::string_view header_of(MHD_Connection* connection, const char* name) {
  return value_of(connection, MHD_HEADER_KIND, name);
}

std::string_view argument_of(MHD_Connection* connection, const char* name) {
  return value_of(connection, MHD_GET_ARGUMENT_KIND, name);
}

RequestHead head_of(MHD_Connection* connection, const char* path, const char* method) {
  const auto* const peer = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CLIENT_ADDRESS);
  return {method,
          path,
          header_of(connection, "Host"),
          header_of(connection, "Origin"),
          header_of(connection, "Sec-Fetch-Site"),
          header_of(connection, "Authorization"),
          header_of(connection, "Content-Length"),
          header_of(connection, "Transfer-Encoding"),
          text_of(peer == nullptr ? nullptr : peer->client_addr)};
}

Answer::Answer(MHD_Connection* connection, std::span<const std::uint8_t> bytes, bool is_static)
    : Answer(connection, MHD_create_response_from_buffer(bytes.size(), const_cast<std::uint8_t*>(bytes.data()),
                                                         is_static ? MHD_RESPMEM_PERSISTENT : MHD_RESPMEM_MUST_COPY)) {}

Answer::Answer(MHD_Connection* connection, MHD_Response* response) : connection_(connection), response_(response) {
  header("Content-Security-Policy", kContentPolicy);
  header("X-Content-Type-Options", "nosniff");
  header("Referrer-Policy", "no-referrer");
  header("Cross-Origin-Resource-Policy", "same-origin");
  header("Cross-Origin-Opener-Policy", "same-origin");
  header("Permissions-Policy", "camera=(), microphone=(), geolocation=()");
}

Answer::~Answer() {
  if (response_ != nullptr) MHD_destroy_response(response_);
}

Answer& Answer::header(const char* name, const char* value) {
  if (response_ != nullptr) MHD_add_response_header(response_, name, value);
  return *this;
}

MHD_Result Answer::send(unsigned status) {
  return response_ == nullptr ? MHD_NO : MHD_queue_response(connection_, status, response_);
}

std::span<const std::uint8_t> bytes_of(std::string_view text) noexcept {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

MHD_Result send_text(MHD_Connection* connection, unsigned status, std::string_view text, const char* type,
                     bool retry_later) {
  Answer answer(connection, bytes_of(text), false);
  answer.header("Content-Type", type).header("Cache-Control", "no-store");
  if (status == MHD_HTTP_METHOD_NOT_ALLOWED) answer.header("Allow", "GET, HEAD");
  if (status == MHD_HTTP_UNAUTHORIZED) answer.header("WWW-Authenticate", "Bearer");
  if (retry_later) answer.header("Retry-After", "60");
  return answer.send(status);
}

MHD_Result send_disk_file(MHD_Connection* connection, const std::string& path, const char* type, const char* missing) {
  FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  struct stat status {};
  if (!file || ::fstat(file.get(), &status) != 0) return send_text(connection, MHD_HTTP_NOT_FOUND, missing, kPlainText);
  Answer answer(connection, MHD_create_response_from_fd64(static_cast<std::uint64_t>(status.st_size), file.get()));
  // From then on the library closes it; where it made no answer it is ours still.
  if (answer) file.let_go();
  answer.header("Content-Type", type).header("Cache-Control", "no-store");
  return answer.send(MHD_HTTP_OK);
}

}  // namespace ninedot
