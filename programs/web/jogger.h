#pragma once
/// The head in the hand of a page: one thread that turns what JogLease allows into commands of a Modbus client.
///
/// It never fights: it takes a head that the service aims or that nobody has, steps back when anybody else writes a
/// command, and afterwards the head follows again if it did before.
#include <condition_variable>
#include <mutex>
#include <string>
#include <string_view>
#include <thread>

#include "base/mono_time.h"
#include "config/config.h"
#include "programs/web/head_link.h"
#include "programs/web/jog_lease.h"
#include "programs/web/jog_path.h"

namespace ninedot {

struct JoggerOptions {
  std::string why_not;  ///< for people: why no page may have the head; empty: it may
  std::string driver;   ///< of [pan_tilt]
  bool follows = true;  ///< what the head does before anybody commands it
  JogAxis pan, tilt;
  std::string host;  ///< the service's Modbus TCP, as it is reached from this machine
  std::uint16_t port = 0;
};

/// For people: why no page may move the head; empty: it may. \param has_token  without one nothing is moved
std::string why_no_head(const Config& config, bool has_token);

/// \param has_token  as above
JoggerOptions jogger_options(const Config& config, bool has_token);

/// What is answered to a page: always the whole state.
struct AimReply {
  unsigned status = 200;  ///< HTTP: 400 not understood, 409 not now: the state says why
  std::string json;
};

/// Threads: any; no call waits for the head. Memory: fixed, but for what an answer takes.
class Jogger {
 public:
  /// Between two commands while the head is jogged: the service takes them as often.
  static constexpr std::chrono::milliseconds kPeriod{20};

  explicit Jogger(JoggerOptions options);
  /// Gives back what a page has; takes a second at most.
  ~Jogger();
  Jogger(const Jogger&) = delete;
  Jogger& operator=(const Jogger&) = delete;

  /// \param text  as aim_request.h has it \param peer  the page's address
  AimReply reply_to(std::string_view text, std::string_view peer);
  /// \param viewer  the page that asks; empty: it has not said
  std::string state_json(std::string_view viewer);

 private:
  using Lock = std::unique_lock<std::mutex>;

  bool carry_out(const AimRequest& request, std::string_view peer, MonoTime now);
  std::string json_of(std::string_view viewer, MonoTime now) const;
  void run();
  std::chrono::milliseconds serve(Lock& lock);
  std::chrono::milliseconds serve_asked(Lock& lock);
  std::chrono::milliseconds serve_held(Lock& lock);
  std::chrono::milliseconds serve_returning(Lock& lock);
  bool is_overruled(const HeadView& view, MonoTime now) const;
  std::string refusal_of(const HeadView& view) const;
  void end(std::string_view why);

  const JoggerOptions options_;
  HeadLink link_;  // of the thread; path_ and the times likewise
  JogPath path_;
  MonoTime held_since_{};  // 0: no page has had it since end()
  MonoTime moved_at_{};    // 0: the last step was none

  mutable std::mutex mutex_;  // of what follows; never held while waiting for the service
  std::condition_variable news_;
  JogLease lease_;
  bool has_news_ = false, ending_ = false;

  std::thread thread_;  // none where no page may have the head
};

}  // namespace ninedot
