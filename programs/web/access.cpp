#include "programs/web/access.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <strings.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>

#include "base/startup_error.h"
#include "drivers/posix/whole_file.h"

namespace ninedot {
namespace {

bool is_ip_address(const std::string& text) {
  in6_addr address{};
  return ::inet_pton(AF_INET, text.c_str(), &address) == 1 || ::inet_pton(AF_INET6, text.c_str(), &address) == 1;
}

/// "sensor:8090" and "[::1]:8090" without the port.
std::string name_of_host(std::string_view host) {
  if (host.starts_with('[')) return std::string(host.substr(1, host.find(']') - 1));
  return std::string(host.substr(0, host.find(':')));
}

HttpRefusal refusal_of_any_body(const RequestHead& head) {
  if ((head.content_length.empty() || head.content_length == "0") && head.transfer_encoding.empty()) return {};
  return {413, "A request that looks has no body.\n"};
}

/// Its length must be told beforehand: what has none may have any.
HttpRefusal refusal_of_body(const RequestHead& head, std::size_t most_bytes) {
  if (head.content_length.empty() || !head.transfer_encoding.empty())
    return {411, "A request that changes something says how long it is.\n"};
  const char* const end = head.content_length.data() + head.content_length.size();
  std::size_t length = 0;
  const auto [read_to, error] = std::from_chars(head.content_length.data(), end, length);
  if (error == std::errc() && read_to == end && length <= most_bytes) return {};
  return {413, "That is more than can be asked for here.\n"};
}

}  // namespace

const PostPath* find_post_path(std::string_view path) noexcept {
  const auto* const found =
      std::find_if(kPostPaths.begin(), kPostPaths.end(), [&](const PostPath& post) { return post.path == path; });
  return found == kPostPaths.end() ? nullptr : found;
}

bool is_same_secret(std::string_view given, std::string_view secret) noexcept {
  // Every character of the secret is looked at, whatever was given.
  unsigned differs = given.size() == secret.size() ? 0 : 1;
  for (std::size_t i = 0; i < secret.size(); ++i) {
    const char other = i < given.size() ? given[i] : '\0';
    differs |= static_cast<unsigned>(static_cast<unsigned char>(secret[i]) ^ static_cast<unsigned char>(other));
  }
  volatile unsigned result = differs;
  return result == 0;
}

std::string read_token(const std::string& file) {
  const auto refuse = [&](const std::string& what) {
    throw StartupError(ExitStatus::kWrongUsage, fmt::format("{}: {}", file, what));
  };
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) refuse(fmt::format("the token can't be read: {}", std::strerror(errno)));
  if ((status.st_mode & (S_IRWXG | S_IRWXO)) != 0)
    refuse(fmt::format("others may read this token: chmod 600 {}, and write another one into it", file));
  std::array<std::uint8_t, 512> buffer{};
  const Result<std::size_t> size = read_whole_file(file.c_str(), buffer);
  const bool is_too_long = !size && size.error().os_errno == EFBIG;
  if (!size && !is_too_long)
    refuse(fmt::format("the token can't be read: {}",
                       size.error().os_errno == 0 ? size.error().text : std::strerror(size.error().os_errno)));
  std::string token(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(size.value_or(buffer.size())));
  while (!token.empty() && (token.back() == '\n' || token.back() == '\r')) token.pop_back();
  if (token.size() < kLeastTokenLength || token.size() >= buffer.size() - 2 ||
      !std::all_of(token.begin(), token.end(), [](char c) { return c > ' ' && c < '\x7F'; }))
    refuse(fmt::format("a token is one line of {} to 500 characters without spaces: openssl rand -hex 16 > {}",
                       kLeastTokenLength, file));
  return token;
}

bool TokenGate::is_closed_for(const std::string& peer, MonoTime now) const noexcept {
  return std::any_of(peers_.begin(), peers_.end(), [&](const Peer& known) {
    return known.wrong >= kMaxWrong && known.address == peer && now - known.since < kPeriod;
  });
}

void TokenGate::note_wrong(const std::string& peer, MonoTime now) {
  auto place = std::find_if(peers_.begin(), peers_.end(), [&](const Peer& known) { return known.address == peer; });
  if (place == peers_.end())
    place =
        std::min_element(peers_.begin(), peers_.end(), [](const Peer& a, const Peer& b) { return a.since < b.since; });
  if (place->address != peer || now - place->since >= kPeriod) *place = {peer, 0, now};
  ++place->wrong;
}

bool Access::is_our_host(std::string_view host) const {
  const std::string name = name_of_host(host);
  // Capitals say nothing (RFC 9110, section 4.2.3), and browsers send none.
  const auto is_name = [&](const std::string& own) { return ::strcasecmp(own.c_str(), name.c_str()) == 0; };
  return is_name("localhost") || is_ip_address(name) || std::ranges::any_of(rules_.names, is_name);
}

HttpRefusal Access::check_token(const RequestHead& head, MonoTime now) {
  if (rules_.token.empty()) return {};
  if (gate_.is_closed_for(head.peer, now))
    return {429, "Too many wrong tokens from this address: wait a minute.\n", true};
  constexpr std::string_view kScheme = "Bearer ";
  if (!head.authorization.starts_with(kScheme)) return {401, "This page needs its token.\n"};
  if (is_same_secret(head.authorization.substr(kScheme.size()), rules_.token)) return {};
  gate_.note_wrong(head.peer, now);
  return {401, "This is not the token of this page.\n"};
}

HttpRefusal Access::check_origin(const RequestHead& head, bool changes) const {
  const HttpRefusal refusal{403, "Not for other pages.\n"};
  const std::string own_origin = fmt::format("{}://{}", rules_.tls ? "https" : "http", head.host);
  if ((changes || !head.origin.empty()) && head.origin != own_origin) return refusal;
  const bool is_own = head.fetch_site.empty() || head.fetch_site == "same-origin";
  // Who follows a link from elsewhere to the page itself is welcome; "none": an address that was typed.
  const bool is_foreign = head.fetch_site == "cross-site" || head.fetch_site == "same-site";
  if (changes ? !is_own : is_foreign && head.path.starts_with("/api/")) return refusal;
  return {};
}

HttpRefusal Access::refusal_of(const RequestHead& head, MonoTime now) {
  const PostPath* const post = head.method == "POST" ? find_post_path(head.path) : nullptr;
  const bool is_post = post != nullptr;
  if (!is_post && head.method != "GET" && head.method != "HEAD")
    return {405, "Nothing can be changed here: only GET and HEAD are answered.\n"};
  if (const HttpRefusal refusal = is_post ? refusal_of_body(head, post->most_bytes) : refusal_of_any_body(head))
    return refusal;
  if (!is_our_host(head.host))
    return {421, "This machine does not know itself by that name: add it to `names` of [web], or use its address.\n"};
  if (const HttpRefusal refusal = check_origin(head, is_post)) return refusal;
  if (is_post && post->changes && rules_.token.empty())
    return {403, "Without a token nothing can be changed: set `token_file` of [web].\n"};
  // What must be known to ask for the token is told without it.
  return !head.path.starts_with("/api/") || head.path == "/api/session" ? HttpRefusal{} : check_token(head, now);
}

}  // namespace ninedot
