#include "programs/web/jogger.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>

#include "base/json_text.h"
#include "programs/assembly/modbus_options.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

// Between two looks at a head that stands: whether somebody else commands it.
constexpr auto kStandingPeriod = 100ms;
// Between two attempts to give it back; and what a controller that writes set-points and command apart may take.
constexpr auto kReturnPeriod = 200ms;
// A head that was told to stand still follows for as long, at most: until the service's next report.
constexpr auto kHearsWithin = 1s;
constexpr std::chrono::milliseconds kForEver{-1}, kAtOnce{0};

JogAxis jog_axis(const HeadAxisConfig& axis) {
  return {axis.min_deg, axis.max_deg, std::min(axis.slew_deg_per_s, JogPath::kFastest_deg_s)};
}

std::string axis_json(const JogAxis& axis) {
  return fmt::format(R"({{"min":{:.9g},"max":{:.9g},"fastest":{:.9g}}})", axis.min_deg, axis.max_deg,
                     axis.fastest_deg_s);
}

const char* name_of(JogLease::Phase phase) {
  switch (phase) {
    case JogLease::Phase::kAsked:
      return "asked";
    case JogLease::Phase::kHeld:
      return "held";
    case JogLease::Phase::kReturning:
      return "returning";
    case JogLease::Phase::kFree:
      break;
  }
  return "free";
}

}  // namespace

std::string why_no_head(const Config& config, bool has_token) {
  if (config.pan_tilt.driver == "none") return "No pan/tilt head is configured: set `driver` of [pan_tilt].";
  if (!config.modbus_tcp.enabled)
    return "The page moves the head as a Modbus client: give the configuration a [modbus.tcp].";
  if (!config.modbus.allow_writes)
    return "The service takes no commands: set `allow_writes = true` under [modbus], and start it again.";
  if (!has_token)
    return "The head moves for those alone who have a token: set `token_file` of [web], and start ninedot-web again.";
  return "";
}

JoggerOptions jogger_options(const Config& config, bool has_token) {
  return {why_no_head(config, has_token), config.pan_tilt.driver,         config.pan_tilt.follow,
          jog_axis(config.pan_tilt.pan),  jog_axis(config.pan_tilt.tilt), address_from_here(config.modbus_tcp),
          config.modbus_tcp.port};
}

Jogger::Jogger(JoggerOptions options)
    : options_(std::move(options)), link_(options_.host, options_.port), path_(options_.pan, options_.tilt) {
  if (!options_.why_not.empty()) return;
  // A page's process that was killed in the middle of it has left the head standing.
  if (options_.follows) lease_.clear_up(mono_now());
  thread_ = std::thread([this] { run(); });
}

Jogger::~Jogger() {
  if (!thread_.joinable()) return;
  {
    const Lock lock(mutex_);
    ending_ = true;
  }
  news_.notify_one();
  thread_.join();
}

AimReply Jogger::reply_to(std::string_view text, std::string_view peer) {
  const auto request = parse_aim_request(text);
  if (!request) return {400, "{}"};
  const Lock lock(mutex_);
  const MonoTime now = mono_now();
  const bool is_done = options_.why_not.empty() && !ending_ && carry_out(*request, peer, now);
  return {is_done ? 200U : 409U, json_of(request->viewer, now)};
}

bool Jogger::carry_out(const AimRequest& request, std::string_view peer, MonoTime now) {
  // The thread may be late; what time has ended is over all the same.
  const auto before = lease_.phase();
  const bool moved = lease_.rates(now).moves();
  lease_.step(now);
  bool is_done = false;
  switch (request.verb) {
    case AimVerb::kTake:
      is_done = lease_.take(request.viewer, peer, now);
      break;
    case AimVerb::kJog:
      is_done = lease_.jog(request, now);
      break;
    case AimVerb::kGive:
      is_done = lease_.give(request.viewer, now);
      break;
    case AimVerb::kFollow:
      is_done = lease_.follow(request.viewer, peer, now);
      break;
  }
  if (lease_.phase() != before || lease_.rates(now).moves() != moved) {
    has_news_ = true;
    news_.notify_one();
  }
  return is_done;
}

std::string Jogger::state_json(std::string_view viewer) {
  const Lock lock(mutex_);
  return json_of(viewer, mono_now());
}

std::string Jogger::json_of(std::string_view viewer, MonoTime now) const {
  return fmt::format(
      R"({{"now":{},"why_not":{},"driver":{},"follows":{},"pan":{},"tilt":{},"phase":"{}","mine":{},"holder":{},"note":{}}})",
      std::chrono::floor<std::chrono::milliseconds>(now.time_since_epoch()).count(), json_text(options_.why_not),
      json_text(options_.driver), options_.follows, axis_json(options_.pan), axis_json(options_.tilt),
      name_of(lease_.phase()), lease_.is_holder(viewer), json_text(lease_.peer()), json_text(lease_.note()));
}

void Jogger::run() {
  Lock lock(mutex_);
  while (!ending_) {
    const auto pause = serve(lock);
    const auto is_due = [this] { return ending_ || has_news_; };
    if (pause == kForEver)
      news_.wait(lock, is_due);
    else
      news_.wait_for(lock, pause, is_due);
    has_news_ = false;
  }
  lease_.give_back("ninedot-web has ended.", mono_now());
  if (lease_.phase() == JogLease::Phase::kReturning) serve_returning(lock);
}

std::chrono::milliseconds Jogger::serve(Lock& lock) {
  switch (lease_.step(mono_now())) {
    case JogLease::Phase::kAsked:
      return serve_asked(lock);
    case JogLease::Phase::kHeld:
      return serve_held(lock);
    case JogLease::Phase::kReturning:
      return serve_returning(lock);
    case JogLease::Phase::kFree:
      break;
  }
  link_.close();
  return kForEver;
}

void Jogger::end(std::string_view why) {
  lease_.end(why);
  if (held_since_ == MonoTime{}) return;
  held_since_ = {};
  fmt::print(stderr, "ninedot-web: no page has the head{}{}\n", why.empty() ? "" : ": ", why);
}

std::string Jogger::refusal_of(const HeadView& view) const {
  if (!view.has_head) return "The service has no pan/tilt head.";
  if (!view.writes_enabled) return "The service takes no commands: it runs with `allow_writes = false`.";
  if (view.follows_by_state || HeadLink::is_of_page(view)) return "";
  if (view.command == Command::kPoint)
    return "A controller sent the head where it stands. \"Automatic again\" takes it away from there, if that may be.";
  if (view.command == Command::kPark)
    return "A controller parked the head. \"Automatic again\" takes it away from there, if that may be.";
  return "";
}

std::chrono::milliseconds Jogger::serve_asked(Lock& lock) {
  lock.unlock();
  link_.close();  // what was told for another page is no concern of this one
  const Result<HeadView> view = link_.look();
  const std::string refusal =
      view ? refusal_of(*view) : std::string("The service does not answer: ") + view.error().text;
  lock.lock();
  if (lease_.phase() != JogLease::Phase::kAsked) return kAtOnce;
  if (!refusal.empty()) {
    end(refusal);
    return kAtOnce;
  }
  const bool follows_by_command =
      view->command == Command::kFollow || (view->command == Command::kNone && options_.follows);
  held_since_ = mono_now();
  lease_.grant(view->follows_by_state || follows_by_command, held_since_);
  path_.stand(view->at);
  moved_at_ = {};
  fmt::print(stderr, "ninedot-web: a page at {} has the head\n", lease_.peer());
  return kAtOnce;
}

bool Jogger::is_overruled(const HeadView& view, MonoTime now) const {
  return link_.is_overruled(view) || (view.follows_by_state && now - held_since_ > kHearsWithin);
}

std::chrono::milliseconds Jogger::serve_held(Lock& lock) {
  lock.unlock();
  const Result<HeadView> view = link_.look();
  lock.lock();
  if (lease_.phase() != JogLease::Phase::kHeld) return kAtOnce;
  // After the look, which may have taken its time.
  const MonoTime now = mono_now();
  if (!view) {
    lease_.give_back(std::string("The service does not answer: ") + view.error().text, now);
    return kReturnPeriod;
  }
  if (is_overruled(*view, now)) {
    constexpr const char* kWhy = "A controller commands the head: it is no longer the page's.";
    // One whose number is still ours has set-points written, and no command yet: that comes now, or was none.
    const bool is_under_way = HeadLink::is_of_page(*view) && !view->follows_by_state;
    if (!is_under_way)
      end(kWhy);
    else
      lease_.give_back(kWhy, now);
    return kReturnPeriod;
  }
  const JogRates rates = lease_.rates(now);
  const bool is_stuck = view->inhibited || view->failed;
  const bool moves = rates.moves() && !is_stuck;
  if (is_stuck) path_.stand(view->at);  // or it would set out by itself when it may move again
  if (moves) path_.advance(rates, view->at, moved_at_ == MonoTime{} ? kPeriod : now - moved_at_);
  moved_at_ = moves ? now : MonoTime{};
  const HeadDegrees to = path_.set_point();
  if (!link_.has_told(to)) {
    lock.unlock();
    const Result<void> done = link_.point(to);
    lock.lock();
    if (!done && done.error().os_errno == EBUSY) return kAtOnce;
    if (!done) lease_.give_back(std::string("The service does not take commands: ") + done.error().text, now);
  }
  return moves ? kPeriod : kStandingPeriod;
}

std::chrono::milliseconds Jogger::serve_returning(Lock& lock) {
  const bool must_follow = lease_.must_follow(), from_anybody = lease_.from_anybody();
  const std::string why = lease_.note();
  Result<void> done;
  if (must_follow) {
    lock.unlock();
    const Result<HeadView> view = link_.look();
    if (!view)
      done = tl::unexpected<Error>(view.error());
    else if (from_anybody || HeadLink::is_of_page(*view))
      done = link_.follow();
    lock.lock();
  }
  if (lease_.phase() != JogLease::Phase::kReturning) return kAtOnce;
  if (!done) return kReturnPeriod;
  end(why);
  return kAtOnce;
}

}  // namespace ninedot
