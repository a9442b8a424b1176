#pragma once
/// Requests and answers as libmicrohttpd has them: what every one of ours carries.
#include <microhttpd.h>

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "programs/web/access.h"

namespace ninedot {

inline constexpr const char* kPlainText = "text/plain; charset=utf-8";
inline constexpr const char* kJsonText = "application/json";

/// Of a request; empty: it has none. Lifetime: the connection's.
std::string_view header_of(MHD_Connection* connection, const char* name);
std::string_view argument_of(MHD_Connection* connection, const char* name);
RequestHead head_of(MHD_Connection* connection, const char* path, const char* method);

/// One answer, with what forbids a page whatever ours does not do. Threads: the library's.
class Answer {
 public:
  /// \param is_static  the bytes outlive every answer: they are not copied
  Answer(MHD_Connection* connection, std::span<const std::uint8_t> bytes, bool is_static);
  /// \param response  made by the caller, this object's from now on; null: out of memory, and nothing can be sent
  Answer(MHD_Connection* connection, MHD_Response* response);
  ~Answer();
  Answer(const Answer&) = delete;
  Answer& operator=(const Answer&) = delete;

  explicit operator bool() const noexcept { return response_ != nullptr; }
  Answer& header(const char* name, const char* value);
  MHD_Result send(unsigned status);

 private:
  MHD_Connection* connection_;
  MHD_Response* response_;
};

std::span<const std::uint8_t> bytes_of(std::string_view text) noexcept;

MHD_Result send_text(MHD_Connection* connection, unsigned status, std::string_view text, const char* type,
                     bool retry_later = false);

/// A file as it lies on the disk, never one that a link leads to. \param missing  what is said where there is none
MHD_Result send_disk_file(MHD_Connection* connection, const std::string& path, const char* type, const char* missing);

}  // namespace ninedot
