#pragma once
/// Requests below /api/recordings that look: the list, a file of a recording, all of one as an archive.
#include <functional>
#include <memory>
#include <string_view>

#include "programs/web/http_answer.h"
#include "programs/web/recorder.h"

namespace ninedot {

inline constexpr std::string_view kRecordingsPath = "/api/recordings";

/// Files go to the connection as they lie on the disk: nothing is decoded or encoded for whoever looks, so that who
/// has the head in hand waits for nobody's replay.
/// Memory: 64 kB for each archive. Threads: the HTTP library's.
class RecordingsApi {
 public:
  /// Archives at a time.
  static constexpr int kMostDownloads = 2;

  explicit RecordingsApi(Recorder& recorder) : recorder_(recorder) {}

  static bool is_for(std::string_view path) noexcept {
    return path == kRecordingsPath || (path.starts_with(kRecordingsPath) && path[kRecordingsPath.size()] == '/');
  }
  /// \param path  is_for \param on_progress  called whenever part of an archive went on its way
  MHD_Result answer(MHD_Connection* connection, std::string_view path, std::function<void()> on_progress);

 private:
  MHD_Result send_archive(MHD_Connection* connection, std::string_view name, const std::string& folder,
                          std::function<void()> on_progress);

  Recorder& recorder_;
  int downloads_ = 0;
};

}  // namespace ninedot
