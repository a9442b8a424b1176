#include "programs/commands/candidate.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstring>
#include <string_view>
#include <utility>

#include "base/mono_time.h"
#include "base/startup_error.h"
#include "drivers/posix/text_file.h"
#include "programs/commands/config_change.h"

namespace ninedot {
namespace {

constexpr std::chrono::seconds kPatience{10};
constexpr std::array kVerbs{std::pair{std::string_view("apply "), CandidateKind::kConfiguration},
                            std::pair{std::string_view("calibration "), CandidateKind::kCalibration},
                            std::pair{std::string_view("head "), CandidateKind::kHead},
                            std::pair{std::string_view("map "), CandidateKind::kMap}};
constexpr std::size_t kMaxHead_bytes = 32;

[[noreturn]] void refuse(const std::string& what) { throw StartupError(ExitStatus::kWrongUsage, what); }

/// Appends what is there. \return  whether more may come
bool read_more(int descriptor, MonoTime until, std::string& text) {
  std::array<char, 16384> part{};
  pollfd wanted{descriptor, POLLIN, 0};
  for (;;) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(until - mono_now()).count();
    const int ready = ::poll(&wanted, 1, static_cast<int>(std::max<std::int64_t>(0, left)));
    if (ready == 0) refuse(fmt::format("the request did not come whole within {} s", kPatience.count()));
    const ssize_t count = ready < 0 ? -1 : ::read(descriptor, part.data(), part.size());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) refuse(fmt::format("the request can't be read: {}", std::strerror(errno)));
    text.append(part.data(), static_cast<std::size_t>(count));
    return count > 0;
  }
}

/// \return  0: it is none
std::size_t number_in(std::string_view digits) {
  std::size_t number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  return error == std::errc() && end == digits.data() + digits.size() ? number : 0;
}

std::pair<CandidateKind, std::size_t> told_by(std::string_view head) {
  for (const auto& [verb, kind] : kVerbs) {
    const std::size_t length = head.starts_with(verb) ? number_in(head.substr(verb.size())) : 0;
    if (length > kMaxApplied_bytes) refuse(fmt::format("longer than {} bytes: is it such a file?", kMaxApplied_bytes));
    if (length > 0) return {kind, length};
  }
  refuse(
      "that is no request: a line `apply BYTES`, `calibration BYTES`, `head BYTES` or `map BYTES`, then so many bytes");
}

}  // namespace

std::string read_candidate(const std::string& path) {
  std::string text = read_text_file(path == "-" ? "/dev/stdin" : path, kMaxApplied_bytes);
  if (text.empty()) refuse((path == "-" ? "standard input" : path) + ": is empty");
  return text;
}

Candidate read_request(int descriptor) {
  const MonoTime until = mono_now() + kPatience;
  std::string text;
  while (text.find('\n') == std::string::npos && text.size() < kMaxHead_bytes && read_more(descriptor, until, text)) {
  }
  const std::size_t head = std::min(text.find('\n'), text.size());
  const auto [kind, length] = told_by(std::string_view(text).substr(0, head));
  text.erase(0, head + 1);
  while (text.size() < length && read_more(descriptor, until, text)) {
  }
  if (text.size() != length)
    refuse(fmt::format("the request holds {} of the {} bytes that it told of, so nothing is changed", text.size(),
                       length));
  return {kind, std::move(text)};
}

}  // namespace ninedot
