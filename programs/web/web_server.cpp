// Long polling: a page asks for the next message and its connection is laid aside until there is one, so that a slow
// page gets fewer messages and no queue exists anywhere. A connection is the library's; what is kept here of it is one
// entry in a fixed table, for the deadline by which its request must have come.
#include "programs/web/web_server.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <microhttpd.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include "base/inline_vector.h"
#include "base/startup_error.h"
#include "config/config_checks.h"
#include "drivers/posix/text_file.h"
#include "programs/web/configuration_answers.h"
#include "programs/web/http_answer.h"
#include "programs/web/job_answers.h"
#include "programs/web/large_body.h"
#include "programs/web/live_feed.h"
#include "programs/web/live_json.h"
#include "programs/web/page_files.h"
#include "programs/web/recordings_api.h"
#include "programs/web/viewers.h"
#include "proto/register_document.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kRequestMemory_bytes = std::size_t{16} * 1024;
constexpr std::size_t kMaxPem_bytes = std::size_t{64} * 1024;
// How late a frame may be noticed where each one is wanted: a tenth of the time between two at 35 Hz.
constexpr auto kLookForFrame = 3ms;

std::chrono::nanoseconds period_of(double rate_hz) {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::duration<double>(1 / rate_hz));
}

sockaddr_storage address_of(const WebConfig& web) {
  sockaddr_storage storage{};
  auto& v4 = reinterpret_cast<sockaddr_in&>(storage);
  auto& v6 = reinterpret_cast<sockaddr_in6&>(storage);
  if (::inet_pton(AF_INET, web.listen.c_str(), &v4.sin_addr) == 1) {
    v4.sin_family = AF_INET;
    v4.sin_port = htons(web.port);
  } else if (::inet_pton(AF_INET6, web.listen.c_str(), &v6.sin6_addr) == 1) {
    v6.sin6_family = AF_INET6;
    v6.sin6_port = htons(web.port);
  }
  return storage;
}

MHD_Result send_file(MHD_Connection* connection, std::string_view path) {
  const std::string_view name = path == "/" ? "index.html" : path.substr(1);
  const auto files = page_files();
  const auto file = std::find_if(files.begin(), files.end(), [&](const PageFile& f) { return f.name == name; });
  if (file == files.end()) return send_text(connection, MHD_HTTP_NOT_FOUND, "There is no such page.\n", kPlainText);
  const bool is_known = header_of(connection, "If-None-Match") == file->tag;
  Answer answer(connection, is_known ? std::span<const std::uint8_t>() : file->bytes, true);
  answer.header("Content-Type", content_type_of(name)).header("ETag", file->tag).header("Cache-Control", "no-cache");
  return answer.send(is_known ? MHD_HTTP_NOT_MODIFIED : MHD_HTTP_OK);
}

/// Four bytes, big-endian, of the JSON's length; the JSON; the JPEG file.
MHD_Result send_message(MHD_Connection* connection, const LiveMessage& message, bool with_picture) {
  const auto length = static_cast<std::uint32_t>(message.json.size());
  std::string body;
  body.reserve(4 + message.json.size() + message.jpeg.size());
  for (const unsigned shift : {24U, 16U, 8U, 0U}) body += static_cast<char>((length >> shift) & 0xFFU);
  body += message.json;
  if (with_picture) body += message.jpeg;
  Answer answer(connection, bytes_of(body), false);
  answer.header("Content-Type", "application/octet-stream").header("Cache-Control", "no-store");
  return answer.send(MHD_HTTP_OK);
}

void forget_log(void* /*self*/, const char* /*format*/, va_list /*arguments*/) {
  // What strangers send is no line of ours.
}

/// No path or argument of ours has any: what comes with some is another one, %00 and %2F included.
std::size_t leave_escapes(void* /*self*/, MHD_Connection* /*connection*/, char* text) { return std::strlen(text); }

/// Empty where none is named, and nowhere else: whoever names a key has the page served by TLS, or not at all.
std::string pem_text(const std::string& file) {
  if (file.empty()) return {};
  std::string text = read_text_file(file, kMaxPem_bytes);
  if (text.empty())
    throw StartupError(ExitStatus::kWrongUsage,
                       fmt::format("{}: is empty: write the certificate or the key into it, in PEM form", file));
  return text;
}

void refuse_open_key(const std::string& file) {
  struct stat status {};
  if (!file.empty() && ::stat(file.c_str(), &status) == 0 && (status.st_mode & (S_IRWXG | S_IRWXO)) != 0)
    throw StartupError(ExitStatus::kWrongUsage, fmt::format("{}: others may read this key: chmod 600 {}", file, file));
}

}  // namespace

class WebServer::Daemon {
 public:
  explicit Daemon(WebServerOptions options)
      : options_(std::move(options)),
        period_(period_of(options_.web.pictures_per_s)),
        every_period_(period_of(std::max(options_.web.ar_pictures_per_s, options_.web.pictures_per_s))),
        access_(options_.rules),
        recordings_(options_.recorder),
        feed_(options_.tap_path, options_.web.quality),
        registers_json_(register_map_json()) {
    start();
  }
  ~Daemon() {
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
      resume_all();
    }
    MHD_stop_daemon(daemon_);
  }
  Daemon(const Daemon&) = delete;
  Daemon& operator=(const Daemon&) = delete;

  void run(const std::function<bool()>& is_over) {
    MonoTime due = mono_now();  // when those get a message who want some frames, not every one
    while (!is_over()) {
      close_slow_connections(mono_now());
      const TapDemand demand = wait_for_viewers();
      const MonoTime now = mono_now();
      if (demand == TapDemand::kNothing) {
        feed_.rest();
        due = now;
        continue;
      }
      // The feed is this thread's alone; only the finished message is shared.
      hand_out(feed_.next(now, demand), now >= due);
      if (now >= due) due = std::max(due + period_, mono_now());
      if (demand == TapDemand::kSome)
        std::this_thread::sleep_until(due);
      else
        wait_for_frame(now);
    }
  }

 private:
  struct Guest {
    int socket = -1;
    MonoTime since{};          // when it connected, when its request was whole, or when that had its answer
    bool is_answered = false;  // its request is whole
    InlineVector<char, kMostBody_bytes> body;
  };

  /// What those who look want: nothing where nobody has come for a fifth of a second.
  TapDemand wait_for_viewers() {
    std::unique_lock lock(mutex_);
    const bool has_viewers = viewers_.count(mono_now()) > 0;
    if (!has_viewers) somebody_.wait_for(lock, 200ms, [&] { return viewers_.count(mono_now()) > 0; });
    if (!has_viewers) return TapDemand::kNothing;
    return viewers_.want_every(mono_now()) ? TapDemand::kEvery : TapDemand::kSome;
  }

  void hand_out(std::shared_ptr<const LiveMessage> message, bool is_for_all) {
    const std::lock_guard lock(mutex_);
    if (is_for_all) newest_for_all_ = message->number;
    message_ = std::move(message);
    resume_all();
  }

  /// Until the frame after that of `since`, or for as long as anybody is ever left without a message. The tap wakes
  /// nobody: the frame loop would have to.
  void wait_for_frame(MonoTime since) {
    std::this_thread::sleep_until(since + every_period_);
    while (!feed_.has_newer() && mono_now() - since < period_) std::this_thread::sleep_for(kLookForFrame);
  }

  void start() {
    const WebConfig& web = options_.web;
    refuse_open_key(web.key);
    key_ = pem_text(web.key);
    certificate_ = pem_text(web.certificate);
    sockaddr_storage address = address_of(web);
    unsigned flags = MHD_USE_EPOLL_INTERNAL_THREAD | MHD_ALLOW_SUSPEND_RESUME | MHD_USE_ERROR_LOG;
    // "::" is all networks, those of IPv4 too.
    if (address.ss_family == AF_INET6)
      flags |= static_cast<unsigned>(web.listen == "::" ? MHD_USE_DUAL_STACK : MHD_USE_IPv6);
    std::vector<MHD_OptionItem> extra;
    if (!key_.empty()) {
      flags |= MHD_USE_TLS;
      extra.push_back({MHD_OPTION_HTTPS_MEM_KEY, 0, key_.data()});
      extra.push_back({MHD_OPTION_HTTPS_MEM_CERT, 0, certificate_.data()});
    }
    extra.push_back({MHD_OPTION_END, 0, nullptr});
    // Not MHD_OPTION_LISTENING_ADDRESS_REUSE: it lets two programs serve one port, by turns (SO_REUSEPORT). Without it
    // the library asks for SO_REUSEADDR, and a restart need not wait for what the kernel keeps of old connections.
    errno = 0;
    daemon_ = MHD_start_daemon(flags, 0, nullptr, nullptr, &Daemon::on_request, this,  //
                               MHD_OPTION_EXTERNAL_LOGGER, &forget_log, nullptr,       //
                               MHD_OPTION_SOCK_ADDR, reinterpret_cast<sockaddr*>(&address), MHD_OPTION_CONNECTION_LIMIT,
                               kConnections,                                                //
                               MHD_OPTION_PER_IP_CONNECTION_LIMIT, kConnectionsOfOne,       //
                               MHD_OPTION_CONNECTION_TIMEOUT, 30U,                          //
                               MHD_OPTION_CONNECTION_MEMORY_LIMIT, kRequestMemory_bytes,    //
                               MHD_OPTION_NOTIFY_CONNECTION, &Daemon::on_connection, this,  //
                               MHD_OPTION_NOTIFY_COMPLETED, &Daemon::on_answered, this,     //
                               MHD_OPTION_UNESCAPE_CALLBACK, &leave_escapes, nullptr, MHD_OPTION_ARRAY, extra.data(),
                               MHD_OPTION_END);
    if (daemon_ != nullptr) return;
    const int error = errno;
    throw StartupError(ExitStatus::kWorkFailed,
                       fmt::format("{} port {} can't be served: {}", web.listen, web.port,
                                   error != 0 ? std::strerror(error) : "is the certificate one, and of this key?"));
  }

  static MHD_Result on_request(void* self, MHD_Connection* connection, const char* path, const char* method,
                               const char* /*version*/, const char* upload, std::size_t* upload_bytes, void** request) {
    // Called at the head, for each part of a body, and once more at the request's end. What is refused is refused at
    // the head: where a body follows the library closes the connection then, instead of reading it.
    auto& daemon = *static_cast<Daemon*>(self);
    if (*request != nullptr && *upload_bytes != 0) {
      const std::string_view part(upload, std::exchange(*upload_bytes, 0));
      return daemon.take_body(connection, part) ? MHD_YES : MHD_NO;
    }
    if (*request != nullptr) return daemon.answer(connection, path, method);
    *request = &daemon;
    const RequestHead head = head_of(connection, path, method);
    HttpRefusal refusal = daemon.access_.refusal_of(head, mono_now());
    if (!refusal) refusal = daemon.make_room(connection, head);
    if (!refusal) return MHD_YES;
    return send_text(connection, refusal.status, refusal.text, kPlainText, refusal.retry_later);
  }

  /// For a body that is too long for its guest.
  HttpRefusal make_room(MHD_Connection* connection, const RequestHead& head) {
    const PostPath* const post = head.method == "POST" ? find_post_path(head.path) : nullptr;
    if (post == nullptr || post->most_bytes <= kMostBody_bytes) return {};
    const std::lock_guard lock(mutex_);
    if (large_body_.take(connection)) return {};
    return {503, "Somebody else is sending something as long at this moment: try again.\n", true};
  }

  bool take_body(MHD_Connection* connection, std::string_view part) {
    const std::lock_guard lock(mutex_);
    if (large_body_.is_of(connection)) return large_body_.append(part);
    Guest* const guest = guest_of(connection);
    return guest != nullptr &&
           std::all_of(part.begin(), part.end(), [&](char c) { return guest->body.try_push_back(c); });
  }

  MHD_Result answer(MHD_Connection* connection, const char* path, const char* method) {
    const MonoTime now = mono_now();
    const RequestHead head = head_of(connection, path, method);
    InlineVector<char, kMostBody_bytes> small;
    {
      const std::lock_guard lock(mutex_);
      if (Guest* guest = guest_of(connection); guest != nullptr && !guest->is_answered) {
        guest->since = now;
        guest->is_answered = true;
        small = guest->body;
      }
    }
    const std::string_view body =
        large_body_.is_of(connection) ? large_body_.text() : std::string_view(small.begin(), small.size());
    if (head.path.starts_with(kConfigurationPath))
      return answer_configuration(connection, head, body, options_.desk, !options_.rules.token.empty());
    if (is_below(head.path, kCalibratePath))
      return answer_job(connection, head, kCalibratePath, body, options_.calibrations);
    if (is_below(head.path, kBuildMapPath)) return answer_job(connection, head, kBuildMapPath, body, options_.maps);
    if (RecordingsApi::is_for(head.path)) return answer_recordings(connection, head, body);
    if (head.method == "POST") {
      const AimReply reply = options_.jogger.reply_to(body, head.peer);
      return send_text(connection, reply.status, reply.json, kJsonText);
    }
    if (head.path == "/api/aim")
      return send_text(connection, MHD_HTTP_OK, options_.jogger.state_json(argument_of(connection, "viewer")),
                       kJsonText);
    if (head.path == "/api/live") return answer_live(connection, now);
    if (head.path == "/api/session")
      return send_text(connection, MHD_HTTP_OK,
                       fmt::format(R"({{"version":"{}","token":{},"tls":{},"loopback":{}}})", NINEDOT_VERSION,
                                   !options_.rules.token.empty(), options_.rules.tls, is_loopback(options_.web.listen)),
                       kJsonText);
    if (head.path == "/api/registers") return send_text(connection, MHD_HTTP_OK, registers_json_, kJsonText);
    if (head.path == "/api/map") return send_text(connection, MHD_HTTP_OK, options_.map_json(), kJsonText);
    return send_file(connection, head.path);
  }

  MHD_Result answer_recordings(MHD_Connection* connection, const RequestHead& head, std::string_view body) {
    if (head.method == "POST") {
      const RecorderReply reply = options_.recorder.reply_to(body);
      return send_text(connection, reply.status, reply.json, kJsonText);
    }
    // An archive takes longer than any other answer: it has its time as long as it is taken.
    return recordings_.answer(connection, head.path, [this, connection] {
      const std::lock_guard lock(mutex_);
      if (Guest* const guest = guest_of(connection)) guest->since = mono_now();
    });
  }

  MHD_Result answer_live(MHD_Connection* connection, MonoTime now) {
    const std::string_view name = argument_of(connection, "viewer");
    if (!Viewers::is_name(name))
      return send_text(connection, MHD_HTTP_BAD_REQUEST, "viewer= is 8 to 32 letters and digits.\n", kPlainText);
    std::unique_lock lock(mutex_);
    Viewers::Seat* const seat = viewers_.seat_of(name, now);
    if (seat == nullptr)
      return send_text(connection, MHD_HTTP_SERVICE_UNAVAILABLE,
                       "Sixteen pages are looking already: close one of them, this one tries again by itself.\n",
                       kPlainText, true);
    seat->wants_every = argument_of(connection, "every") == "1";
    somebody_.notify_one();
    if (ending_) return MHD_NO;
    const std::uint64_t newest = seat->wants_every && message_ ? message_->number : newest_for_all_;
    if (message_ && newest > seat->served && now - made_at_ < std::chrono::seconds(1)) {
      seat->served = message_->number;
      const auto message = message_;
      lock.unlock();
      return send_message(connection, *message, argument_of(connection, "picture") != "0");
    }
    // Called once more for this very request when the next message is there.
    MHD_suspend_connection(connection);
    waiting_.push_back(connection);
    return MHD_YES;
  }

  /// With the mutex held.
  void resume_all() {
    made_at_ = mono_now();
    for (MHD_Connection* connection : waiting_) MHD_resume_connection(connection);
    waiting_.clear();
  }

  static int socket_of(MHD_Connection* connection) {
    const auto* const info = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD);
    return info == nullptr ? -1 : info->connect_fd;
  }
  Guest* guest_of(MHD_Connection* connection) {
    const int socket = socket_of(connection);
    const auto guest = std::find_if(guests_.begin(), guests_.end(), [&](const Guest& g) { return g.socket == socket; });
    return socket < 0 || guest == guests_.end() ? nullptr : &*guest;
  }

  static void on_connection(void* self, MHD_Connection* connection, void** /*context*/,
                            MHD_ConnectionNotificationCode code) {
    auto& daemon = *static_cast<Daemon*>(self);
    const std::lock_guard lock(daemon.mutex_);
    if (code == MHD_CONNECTION_NOTIFY_CLOSED) {
      if (Guest* const guest = daemon.guest_of(connection)) *guest = {};
      return;
    }
    const auto place =
        std::find_if(daemon.guests_.begin(), daemon.guests_.end(), [](const Guest& g) { return g.socket < 0; });
    if (place != daemon.guests_.end()) *place = {socket_of(connection), mono_now(), false, {}};
  }

  static void on_answered(void* self, MHD_Connection* connection, void** /*request*/,
                          MHD_RequestTerminationCode /*code*/) {
    auto& daemon = *static_cast<Daemon*>(self);
    const std::lock_guard lock(daemon.mutex_);
    daemon.large_body_.give_back(connection);
    if (Guest* const guest = daemon.guest_of(connection)) {
      guest->since = mono_now();
      guest->is_answered = false;
      guest->body.clear();
    }
  }

  /// The library's own time-out begins anew with each byte, so that one byte a second lasts for ever.
  void close_slow_connections(MonoTime now) {
    const std::lock_guard lock(mutex_);
    for (const Guest& guest : guests_)
      if (guest.socket >= 0 && now - guest.since > (guest.is_answered ? kAnswerPatience : kHeadPatience))
        ::shutdown(guest.socket, SHUT_RDWR);  // the library finds it closed, and ends it
  }

  const WebServerOptions options_;
  const std::chrono::nanoseconds period_, every_period_;  // of messages, at least
  Access access_;                                         // of the library's thread
  RecordingsApi recordings_;                              // likewise
  LiveFeed feed_;                                         // of the caller's of run()
  const std::string registers_json_;
  std::string key_, certificate_;

  std::mutex mutex_;  // of what follows
  std::condition_variable somebody_;
  Viewers viewers_;
  std::array<Guest, kConnections> guests_;
  LargeBody large_body_;  // read by the library's thread alone
  std::vector<MHD_Connection*> waiting_;
  std::shared_ptr<const LiveMessage> message_;
  std::uint64_t newest_for_all_ = 0;  // number of the last one for those who want some frames
  MonoTime made_at_{};
  bool ending_ = false;

  MHD_Daemon* daemon_ = nullptr;
};

WebServer::WebServer(WebServerOptions options) : daemon_(std::make_unique<Daemon>(std::move(options))) {}
WebServer::~WebServer() = default;
void WebServer::run(const std::function<bool()>& is_over) { daemon_->run(is_over); }

}  // namespace ninedot
