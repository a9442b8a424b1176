#pragma once
/// Who may look, and who may change something: decided from a request's head alone, before anything is done for it.
#include <array>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "base/mono_time.h"

namespace ninedot {

/// What a browser or somebody else sent; empty: nothing. Lifetime: as the connection's.
struct RequestHead {
  std::string_view method, path, host, origin, fetch_site, authorization, content_length, transfer_encoding;
  std::string peer;  ///< address without port
};

/// What is answered in the place of what was asked for.
struct HttpRefusal {
  unsigned status = 0;  ///< HTTP status; 0: none, go on
  const char* text = "";
  bool retry_later = false;  ///< with Retry-After
  explicit operator bool() const noexcept { return status != 0; }
};

/// A path to which something is posted, and how long that may be.
struct PostPath {
  std::string_view path;
  std::size_t most_bytes = 0;
  bool changes = true;  ///< something: without a token nobody may
};
/// What more than kMostBody_bytes is for is taken one at a time.
inline constexpr std::size_t kMostBody_bytes = 128;
inline constexpr std::size_t kMostLargeBody_bytes = std::size_t{256} * 1024;
inline constexpr std::size_t kMostNames_bytes = std::size_t{6} * 1024;  ///< of 200 recordings
inline constexpr std::array kPostPaths{PostPath{"/api/aim", kMostBody_bytes},
                                       PostPath{"/api/recordings", kMostBody_bytes},
                                       PostPath{"/api/calibrate", kMostBody_bytes},
                                       PostPath{"/api/map/build", kMostNames_bytes},
                                       PostPath{"/api/configuration/check", kMostLargeBody_bytes, false},
                                       PostPath{"/api/configuration/apply", kMostLargeBody_bytes}};

/// \return  nothing: nothing can be posted there
const PostPath* find_post_path(std::string_view path) noexcept;

/// Length from which a token is no longer guessed: 128 bits as hexadecimal digits.
inline constexpr std::size_t kLeastTokenLength = 32;

/// Whether both are the same, in a time that says nothing of where they differ. \param given  of whatever length
bool is_same_secret(std::string_view given, std::string_view secret) noexcept;

/// The token in `file`: one line of kLeastTokenLength printable characters or more.
/// Throws StartupError(kWrongUsage): not there, readable by others than its owner, too short.
std::string read_token(const std::string& file);

/// Wrong tokens by address: kMaxWrong in kPeriod, then none is looked at until it is over.
/// Memory: a fixed table; whoever was quiet longest gives up its place. Threads: one caller.
class TokenGate {
 public:
  static constexpr int kMaxWrong = 5;
  static constexpr std::chrono::seconds kPeriod{60};

  bool is_closed_for(const std::string& peer, MonoTime now) const noexcept;
  void note_wrong(const std::string& peer, MonoTime now);

 private:
  struct Peer {
    std::string address;
    int wrong = 0;
    MonoTime since{};
  };
  std::array<Peer, 256> peers_;
};

struct AccessRules {
  std::string token;               ///< empty: none is asked for
  std::vector<std::string> names;  ///< by which browsers may call this machine, beside addresses and localhost
  bool tls = false;
};

/// Threads: one caller.
class Access {
 public:
  explicit Access(AccessRules rules) : rules_(std::move(rules)) {}

  /// In this order: a method that looks, no body, a host that is this one (another name that leads here is how a
  /// foreign page gets past the browser's own walls: DNS rebinding), not from another page, the token.
  /// POST to one of kPostPaths changes something: a bounded body, this page's own origin, named as such by the browser,
  /// and the token, which no browser sends by itself; where there is none nothing is changed, on this machine neither.
  /// What changes nothing needs no more than the same origin, and the token where there is one.
  HttpRefusal refusal_of(const RequestHead& head, MonoTime now);
  const AccessRules& rules() const noexcept { return rules_; }

 private:
  bool is_our_host(std::string_view host) const;
  HttpRefusal check_origin(const RequestHead& head, bool changes) const;
  HttpRefusal check_token(const RequestHead& head, MonoTime now);

  const AccessRules rules_;
  TokenGate gate_;
};

}  // namespace ninedot
