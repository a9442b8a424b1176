#pragma once
/// How a calibration fares, for another program: a line of JSON for each piece of news. docs/calibrating.md has the
/// tables.
#include <unistd.h>

#include <string>
#include <string_view>
#include <vector>

#include "base/mono_time.h"
#include "base/startup_error.h"

namespace ninedot {

/// Five lines a second, but for those that tell more than how far it is. Each is written whole, and waits for whoever
/// reads. Threads: one caller.
class JsonNews {
 public:
  /// \param fd  open for as long as this is
  explicit JsonNews(int fd) noexcept : fd_(fd) {}

  /// Whether anything would be said now; spares whoever makes it.
  bool is_due() const noexcept;
  void working(std::string_view what);
  void failed(std::string_view why);

  /// Nobody reads any more: there is no reason to go on.
  bool is_broken() const noexcept { return is_broken_; }

 protected:
  void say(std::string line);

 private:
  int fd_;
  bool is_broken_ = false;
  MonoTime said_at_{};
};

/// \param progress  of the command line: "json", or nothing
/// Calls `work` with news on standard output, or with null; what it throws is told as well, and thrown on.
template <typename News, typename Work>
void with_news(const std::string& progress, const Work& work) {
  if (progress.empty()) return work(static_cast<News*>(nullptr));
  News news(STDOUT_FILENO);
  try {
    work(&news);
  } catch (const StartupError& error) {
    news.failed(error.what());
    throw;
  }
}

/// ["...","..."]
std::string texts_json(const std::vector<std::string>& texts);

}  // namespace ninedot
