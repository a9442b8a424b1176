#pragma once
/// The configuration as the page edits it: read, checked, and handed to `ninedot apply --page` behind a socket. This
/// process may write no file and restart nothing; whoever listens on that socket may, and looks for itself at what it
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
  std::string text;       ///< JSON with 202, else a line for people
};

/// Threads: any. Memory: bounded: what is told of an apply, and for an answer the file three times.
class ConfigurationDesk {
 public:
  /// Lines of an apply, and of a check, that are told: the first ones.
  static constexpr std::size_t kMostLines = 200;

  /// \param config_path  the file that the service reads \param socket_path  of ninedot-apply.socket
  ConfigurationDesk(std::string config_path, std::string socket_path)
      : config_path_(std::move(config_path)), socket_path_(std::move(socket_path)) {}
  /// Lets go of an apply that is under way: it goes on by itself.
  ~ConfigurationDesk();
  ConfigurationDesk(const ConfigurationDesk&) = delete;
  ConfigurationDesk& operator=(const ConfigurationDesk&) = delete;

  /// The file, the one before, whether they may be changed, and the newest apply. \param has_token  the page needs one
  std::string file_json(bool has_token) const;
  /// The newest apply alone.
  std::string apply_json() const;
  /// What `ninedot check --file-only` says of a text, by line.
  std::string check_json(std::string_view text) const;
  /// Begins to put `text` in the file's place. \param tag  of the file that it was made from, as file_json gave it
  DeskReply apply(std::string_view text, std::string_view tag, bool has_token);

  /// An apply went well, a moment ago so that its page has heard of it: true once.
  bool takes_new_file(MonoTime now);

 private:
  std::string why_not(bool has_token) const;
  void hand_over(const std::string& text);
  void hear(std::string_view line);

  const std::string config_path_, socket_path_;
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

/// Every key with its unit, range, default and meaning: the table that docs/configuration.md is made of.
std::string configuration_keys_json();

}  // namespace ninedot
