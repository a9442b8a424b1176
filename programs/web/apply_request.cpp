#include "programs/web/apply_request.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <utility>

#include "base/json_text.h"
#include "base/startup_error.h"
#include "drivers/posix/file_descriptor.h"
#include "drivers/posix/text_file.h"
#include "programs/web/access.h"

namespace ninedot {
namespace {

constexpr int kPatience_s = 240;     // a check, a trial and the way back: one minute, and twice 30 s, with room
constexpr int kSendPatience_s = 10;  // as long as the other side waits for a request
constexpr std::chrono::seconds kUntilHeard{3};
constexpr const char* kHowToPermit =
    "changes from the page are switched off on this machine. To permit them: systemctl enable --now "
    "ninedot-apply.socket. Until then `ninedot apply FILE --config ...` on it does the same";

std::string_view word_of(ApplyEnd end) {
  switch (end) {
    case ApplyEnd::kNone:
      return "none";
    case ApplyEnd::kRunning:
      return "running";
    case ApplyEnd::kUp:
      return "up";
    case ApplyEnd::kUnchanged:
      return "unchanged";
    case ApplyEnd::kRefused:
      return "refused";
    case ApplyEnd::kBack:
      return "back";
    case ApplyEnd::kFailed:
      break;
  }
  return "failed";
}

/// \return  errno
int connect_to(int descriptor, const std::string& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  if (path.size() >= sizeof address.sun_path) return ENAMETOOLONG;
  std::copy(path.begin(), path.end(), address.sun_path);
  return ::connect(descriptor, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 ? 0 : errno;
}

bool send_all(int descriptor, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t count = ::send(descriptor, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(count));
  }
  return true;
}

}  // namespace

ApplyRequest::~ApplyRequest() {
  {
    const std::lock_guard lock(mutex_);
    is_ending_ = true;
    if (socket_ >= 0) ::shutdown(socket_, SHUT_RDWR);
  }
  if (thread_.joinable()) thread_.join();
}

std::string ApplyRequest::why_not(bool has_token) const {
  if (!has_token) return "without a token nothing can be changed: set `token_file` of [web]";
  struct stat status {};
  const bool is_there = ::stat(socket_path_.c_str(), &status) == 0 && S_ISSOCK(status.st_mode);
  return is_there ? "" : kHowToPermit;
}

DeskReply ApplyRequest::begin(std::string_view verb, std::string text, bool has_token) {
  const std::lock_guard one(one_at_a_time_);
  if (const std::string reason = why_not(has_token); !reason.empty()) return {403, reason + "\n"};
  {
    const std::lock_guard lock(mutex_);
    if (end_ == ApplyEnd::kRunning) return {409, "another apply is under way: wait for its end\n"};
  }
  if (thread_.joinable()) thread_.join();
  {
    const std::lock_guard lock(mutex_);
    end_ = ApplyEnd::kRunning;
    phase_ = "sending";
    lines_.clear();
    ++number_;
  }
  thread_ = std::thread([this, verb = std::string(verb), text = std::move(text)] { hand_over(verb, text); });
  return {202, json()};
}

DeskReply ApplyRequest::begin_with_file(std::string_view verb, const std::string& path, bool has_token) {
  try {
    return begin(verb, read_text_file(path, kMostLargeBody_bytes), has_token);
  } catch (const StartupError& error) {
    return {409, std::string(error.what()) + "\n"};
  }
}

std::string ApplyRequest::json() const {
  const std::lock_guard lock(mutex_);
  std::string lines;
  for (const std::string& line : lines_) lines += fmt::format("{}{}", lines.empty() ? "" : ",", json_text(line));
  return fmt::format(R"({{"number":{},"state":"{}","phase":{},"lines":[{}]}})", number_, word_of(end_),
                     json_text(phase_), lines);
}

void ApplyRequest::hand_over(const std::string& verb, const std::string& text) {
  const FileDescriptor descriptor(::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const timeval patience{kPatience_s, 0}, sending{kSendPatience_s, 0};
  ::setsockopt(descriptor.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  ::setsockopt(descriptor.get(), SOL_SOCKET, SO_SNDTIMEO, &sending, sizeof sending);
  const int error = connect_to(descriptor.get(), socket_path_);
  {
    // Shut down by whoever ends, if it is told of in time: one that is not connected yet can't be.
    const std::lock_guard lock(mutex_);
    if (is_ending_) return;
    socket_ = descriptor.get();
  }
  if (error == 0 && send_all(descriptor.get(), fmt::format("{} {}\n", verb, text.size()))) {
    static_cast<void>(send_all(descriptor.get(), text));  // one that reads no further has said why
    std::string line;
    std::array<char, 1024> part{};
    ssize_t count = 0;
    while ((count = ::recv(descriptor.get(), part.data(), part.size(), 0)) > 0 || (count < 0 && errno == EINTR)) {
      for (const char c : std::string_view(part.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0)))) {
        if (c != '\n' && line.size() < kMostLine_bytes) line += c;
        if (c == '\n') hear(std::exchange(line, {}));
      }
    }
  }
  const std::lock_guard lock(mutex_);
  socket_ = -1;
  if (end_ != ApplyEnd::kRunning) return;
  end_ = ApplyEnd::kFailed;
  lines_.push_back(error != 0
                       ? fmt::format("{}: {}", socket_path_, std::strerror(error))
                       : "it ended before it said how: `journalctl -u 'ninedot-apply@*'` on the sensor says more");
}

/// "PHASE: words", as `ninedot apply` prints them.
void ApplyRequest::hear(std::string_view line) {
  constexpr std::array<std::pair<std::string_view, ApplyEnd>, 5> kEnds{{{"up", ApplyEnd::kUp},
                                                                        {"unchanged", ApplyEnd::kUnchanged},
                                                                        {"refused", ApplyEnd::kRefused},
                                                                        {"back", ApplyEnd::kBack},
                                                                        {"failed", ApplyEnd::kFailed}}};
  const std::size_t colon = std::min(line.find(": "), line.size());
  const std::lock_guard lock(mutex_);
  phase_ = line.substr(0, colon);
  for (const auto& [word, end] : kEnds)
    if (phase_ == word) end_ = end;
  if (phase_ == word_of(ApplyEnd::kUp)) {
    has_new_file_ = true;  // in one step with the end: whoever reads that, and asks, is not told otherwise
    changed_at_ = mono_now();
  }
  if (lines_.size() < kMostLines) lines_.emplace_back(line);
}

bool ApplyRequest::takes_new_file(MonoTime now) {
  const std::lock_guard lock(mutex_);
  if (!has_new_file_ || now - changed_at_ <= kUntilHeard) return false;
  has_new_file_ = false;
  return true;
}

}  // namespace ninedot
