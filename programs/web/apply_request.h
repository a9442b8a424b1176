#pragma once
/// One change at a time of what the service reads, asked of `ninedot apply --page` behind a socket. This process may
/// write none of these files and restart nothing; whoever listens on that socket may, and looks for itself at what it
/// is given.
#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

#include "base/mono_time.h"

namespace ninedot {

/// How far the newest apply has come.
enum class ApplyEnd : std::uint8_t { kNone, kRunning, kUp, kUnchanged, kRefused, kBack, kFailed };

struct DeskReply {
  unsigned status = 200;  ///< HTTP: 202 begun, 403 not permitted, 409 one is under way, 412 the file is another one
  std::string text;       ///< JSON with 200 and 202, else a line for people
};

/// Threads: any. Memory: bounded: what is handed over, and the first lines that are told of it.
class ApplyRequest {
 public:
  static constexpr std::size_t kMostLines = 200;
  static constexpr std::size_t kMostLine_bytes = 400;

  /// \param socket_path  of ninedot-apply.socket
  explicit ApplyRequest(std::string socket_path) : socket_path_(std::move(socket_path)) {}
  /// Lets go of one that is under way: it goes on by itself.
  ~ApplyRequest();
  ApplyRequest(const ApplyRequest&) = delete;
  ApplyRequest& operator=(const ApplyRequest&) = delete;

  /// For people, half a sentence; empty: changes may be asked for. \param has_token  the page needs one
  std::string why_not(bool has_token) const;
  /// Begins. \param verb  what `text` is: "apply": a configuration; "calibration": the camera's; "head"; "map"
  DeskReply begin(std::string_view verb, std::string text, bool has_token);
  /// The same of a file. 409: it can't be read.
  DeskReply begin_with_file(std::string_view verb, const std::string& path, bool has_token);
  /// The newest one.
  std::string json() const;
  /// One went well, a moment ago so that its page has heard of it: true once.
  bool takes_new_file(MonoTime now);

 private:
  void hand_over(const std::string& verb, const std::string& text);
  void hear(std::string_view line);

  const std::string socket_path_;
  std::mutex one_at_a_time_;  // of beginning
  std::thread thread_;
  mutable std::mutex mutex_;  // of what follows
  int socket_ = -1;
  ApplyEnd end_ = ApplyEnd::kNone;
  std::string phase_;
  std::deque<std::string> lines_;
  MonoTime changed_at_{};
  std::uint32_t number_ = 0;
  bool has_new_file_ = false;
  bool is_ending_ = false;
};

}  // namespace ninedot
