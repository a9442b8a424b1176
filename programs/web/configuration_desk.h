#pragma once
/// The configuration as the page edits it: read, checked, and handed to whoever may change it.
#include <string>
#include <string_view>

#include "programs/web/apply_request.h"

namespace ninedot {

/// Threads: any. Memory: bounded: for an answer the file three times.
class ConfigurationDesk {
 public:
  /// \param config_path  the file that the service reads \param request  must outlive this
  ConfigurationDesk(std::string config_path, ApplyRequest& request)
      : config_path_(std::move(config_path)), request_(request) {}

  /// The file, the one before, whether they may be changed, and the newest apply. \param has_token  the page needs one
  std::string file_json(bool has_token) const;
  /// What `ninedot check --file-only` says of a text, by line: the first ApplyRequest::kMostLines.
  std::string check_json(std::string_view text) const;
  /// Begins to put `text` in the file's place. \param tag  of the file that it was made from, as file_json gave it
  DeskReply apply(std::string_view text, std::string_view tag, bool has_token);
  /// The newest apply alone, of a calibration as well.
  std::string apply_json() const { return request_.json(); }

 private:
  const std::string config_path_;
  ApplyRequest& request_;
};

/// Every key with its unit, range, default and meaning: the table that docs/configuration.md is made of.
std::string configuration_keys_json();

}  // namespace ninedot
