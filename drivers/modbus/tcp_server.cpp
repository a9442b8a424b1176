#include "drivers/modbus/tcp_server.h"

#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "base/startup_error.h"
#include "drivers/modbus/server_thread.h"
#include "drivers/posix/poll_until.h"

namespace ninedot {
namespace {

constexpr std::size_t kStopIndex = 0, kListenerIndex = 1, kFirstClientIndex = 2;
/// A connection that has sent nothing for so long has no right to a place that another one wants.
constexpr std::chrono::seconds kSilentNewcomer{2};
constexpr std::chrono::milliseconds kOutOfDescriptorsPause{100};
constexpr int kBacklog = 16;

using AddressList = std::unique_ptr<addrinfo, decltype(&::freeaddrinfo)>;

AddressList resolve_numeric(const std::string& host, std::uint16_t port) {
  addrinfo hints{};
  hints.ai_flags = AI_NUMERICHOST | AI_NUMERICSERV | AI_PASSIVE;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (::getaddrinfo(host.c_str(), std::to_string(port).c_str(), &hints, &found) != 0) found = nullptr;
  return {found, &::freeaddrinfo};
}

std::string cannot_listen(const std::string& host, std::uint16_t port, int error) {
  if (error == EINVAL)
    return fmt::format("Modbus TCP cannot listen on '{}': write a numeric address like 127.0.0.1 or ::", host);
  std::string advice = "check the address and port of [modbus.tcp]";
  if (error == EADDRINUSE) advice = "stop the program that uses it, or configure another port in [modbus.tcp]";
  if (error == EACCES) advice = "ports below 1024 need CAP_NET_BIND_SERVICE; configure another port in [modbus.tcp]";
  if (error == EADDRNOTAVAIL) advice = "no interface has this address; configure another one in [modbus.tcp]";
  return fmt::format("Modbus TCP cannot listen on {}:{}: {}; {}", host, port, std::strerror(error), advice);
}

/// \error  as try_listen
Result<FileDescriptor> listen_on(const std::string& host, std::uint16_t port) noexcept {
  const AddressList list = resolve_numeric(host, port);
  if (!list) return fail(Errc::kIo, "no address", EINVAL);
  FileDescriptor fd(::socket(list->ai_family, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int on = 1;
  // A restart must not wait for the last connections' TIME_WAIT.
  if (fd) (void)::setsockopt(fd.get(), SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  // Two sockets may be bound alike with SO_REUSEADDR; only one may listen.
  if (!fd || ::bind(fd.get(), list->ai_addr, list->ai_addrlen) != 0 || ::listen(fd.get(), kBacklog) != 0)
    return fail(Errc::kIo, "cannot listen", errno);
  return fd;
}

FileDescriptor listen_or_refuse(const std::string& host, std::uint16_t port) {
  Result<FileDescriptor> listener = listen_on(host, port);
  if (listener) return *std::move(listener);
  const int error = listener.error().os_errno;
  throw StartupError(error == EINVAL ? ExitStatus::kWrongUsage : ExitStatus::kWorkFailed,
                     cannot_listen(host, port, error));
}

std::uint16_t port_of(int fd) noexcept {
  sockaddr_storage bound{};
  socklen_t size = sizeof bound;
  sockaddr_in any{};
  if (::getsockname(fd, reinterpret_cast<sockaddr*>(&bound), &size) != 0) return 0;
  std::memcpy(&any, &bound, sizeof any);  // the port stands at the same place for IPv6
  return ntohs(any.sin_port);
}

/// Replies leave at once; a peer whose cable was cut is noticed in about half a minute.
void tune(int fd) noexcept {
  const auto set = [fd](int level, int option, int value) {
    (void)::setsockopt(fd, level, option, &value, sizeof value);
  };
  set(IPPROTO_TCP, TCP_NODELAY, 1);
  set(SOL_SOCKET, SO_KEEPALIVE, 1);
  set(IPPROTO_TCP, TCP_KEEPIDLE, 15);
  set(IPPROTO_TCP, TCP_KEEPINTVL, 5);
  set(IPPROTO_TCP, TCP_KEEPCNT, 3);
}

}  // namespace

Result<void> try_listen(const std::string& address, std::uint16_t port) noexcept {
  NINEDOT_TRY([[maybe_unused]] const FileDescriptor listener, listen_on(address, port));
  return {};
}

TcpServer::TcpServer(RegisterBank& bank, const ModbusTcpOptions& options)
    : bank_(bank),
      options_(options),
      filter_(options.allow),
      listener_(listen_or_refuse(options.listen, options.port)) {
  EXPECTS(options.max_clients >= 1 && options.max_clients <= 64);
  port_ = port_of(listener_.get());
  polled_.reserve(kFirstClientIndex + options.max_clients);
  clients_.reserve(options.max_clients);
  thread_ = start_server_thread("modbus-tcp", [this]() noexcept { run(); });
}

TcpServer::~TcpServer() {
  stop_.ring();
  thread_.join();
}

void TcpServer::run() noexcept {
  for (;;) {
    const int ready = poll_once();
    if (polled_[kStopIndex].revents != 0) return;
    if (ready >= 0) serve_round();
  }
}

int TcpServer::poll_once() noexcept {
  MonoTime wake_at = MonoTime::max();
  polled_.clear();
  polled_.push_back({stop_.get(), POLLIN, 0});
  const bool paused = bank_.now() < accept_again_at_;
  if (paused) wake_at = accept_again_at_;
  polled_.push_back({paused ? -1 : listener_.get(), POLLIN, 0});
  {
    const std::lock_guard lock(mutex_);
    for (const auto& client : clients_) {
      polled_.push_back({client->fd(), client->wanted_events(), 0});
      wake_at = std::min(wake_at, client->expires_at(options_.idle_timeout));
      if (const auto due = bank_.check_watchdog(client->session)) wake_at = std::min(wake_at, *due);
    }
  }
  return poll_until(polled_, wake_at);
}

void TcpServer::serve_round() noexcept {
  const std::lock_guard lock(mutex_);
  for (std::size_t i = clients_.size(); i-- > 0;) {
    const short events = polled_[kFirstClientIndex + i].revents;
    if (events == 0) continue;
    const TcpConnection::Outcome outcome = clients_[i]->serve(bank_, events);
    if (outcome == TcpConnection::Outcome::kProtocolError) {
      bank_.counters.bus_errors.fetch_add(1, std::memory_order_relaxed);
      bank_.counters.unreadable_frames.fetch_add(1, std::memory_order_relaxed);
    }
    if (outcome != TcpConnection::Outcome::kOpen) drop(i);
  }
  const MonoTime now = bank_.now();
  drop_expired(now);
  if (polled_[kListenerIndex].revents != 0) accept_clients(now);
}

void TcpServer::drop(std::size_t index) noexcept {
  bank_.client_left(clients_[index]->session);
  clients_.erase(clients_.begin() + static_cast<std::ptrdiff_t>(index));
  bank_.counters.tcp_clients.store(static_cast<std::uint32_t>(clients_.size()), std::memory_order_relaxed);
}

void TcpServer::drop_expired(MonoTime now) noexcept {
  for (std::size_t i = clients_.size(); i-- > 0;) {
    if (!clients_[i]->is_expired(now, options_.idle_timeout)) continue;
    drop(i);
    bank_.counters.connections_expired.fetch_add(1, std::memory_order_relaxed);
  }
}

bool TcpServer::make_room(MonoTime now) noexcept {
  if (clients_.size() < options_.max_clients) return true;
  const auto silent = std::find_if(clients_.begin(), clients_.end(), [now](const auto& client) {
    return client->requests == 0 && now - client->opened_at > kSilentNewcomer;
  });
  if (silent == clients_.end()) return false;
  drop(static_cast<std::size_t>(silent - clients_.begin()));
  bank_.counters.connections_expired.fetch_add(1, std::memory_order_relaxed);
  return true;
}

void TcpServer::accept_clients(MonoTime now) noexcept {
  // A bounded number per round: a flood of connections must not delay those that are served.
  for (int i = 0; i < kBacklog; ++i) {
    sockaddr_storage peer{};
    socklen_t size = sizeof peer;
    FileDescriptor fd(
        ::accept4(listener_.get(), reinterpret_cast<sockaddr*>(&peer), &size, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (!fd) {
      if (errno == EMFILE || errno == ENFILE || errno == ENOBUFS || errno == ENOMEM)
        accept_again_at_ = now + kOutOfDescriptorsPause;
      return;
    }
    if (!filter_.allows(peer)) {
      note_refused(peer, "is not on the list `allow`");
      continue;
    }
    if (!make_room(now)) {
      note_refused(peer, "found no place: all of `max_clients` are taken");
      continue;
    }
    tune(fd.get());
    clients_.push_back(std::make_unique<TcpConnection>(std::move(fd), peer_text(peer), now));
    bank_.counters.connections.fetch_add(1, std::memory_order_relaxed);
    bank_.counters.tcp_clients.store(static_cast<std::uint32_t>(clients_.size()), std::memory_order_relaxed);
  }
}

void TcpServer::note_refused(const sockaddr_storage& peer, const char* why) noexcept {
  bank_.counters.connections_refused.fetch_add(1, std::memory_order_relaxed);
  last_refused_ = peer;
  why_refused_ = why;
}

std::string TcpServer::last_refusal() const {
  const std::lock_guard lock(mutex_);
  return *why_refused_ == '\0' ? "" : fmt::format("{} {}", peer_text(last_refused_), why_refused_);
}

void TcpServer::append_clients(std::vector<ConnectedClient>& clients) const {
  const std::lock_guard lock(mutex_);
  const MonoTime now = bank_.now();
  for (const auto& client : clients_)
    clients.push_back({client->address, client->requests, now - client->opened_at, now - client->last_request_at});
}

}  // namespace ninedot
