#pragma once
/// Modbus TCP: one thread serves all clients from poll(), and never waits for any of them.
#include <poll.h>
#include <sys/socket.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "base/result.h"
#include "drivers/modbus/counters.h"
#include "drivers/modbus/options.h"
#include "drivers/modbus/peer_filter.h"
#include "drivers/modbus/register_bank.h"
#include "drivers/modbus/tcp_connection.h"
#include "drivers/posix/file_descriptor.h"

namespace ninedot {

/// Listens from construction to destruction. The bank must outlive it. Threads: any ordinary one for each method; those
/// that read clients may wait for one round of the server's thread, which waits for no socket.
class TcpServer {
 public:
  /// Throws StartupError naming the address: kWrongUsage where it is none, kWorkFailed where it can't be listened on.
  TcpServer(RegisterBank& bank, const ModbusTcpOptions& options);
  ~TcpServer();
  TcpServer(const TcpServer&) = delete;
  TcpServer& operator=(const TcpServer&) = delete;

  std::uint16_t port() const noexcept { return port_; }
  void append_clients(std::vector<ConnectedClient>& clients) const;
  /// The client that was refused last and why: "10.0.0.9:40012 is not on the list `allow`"; empty: none was.
  std::string last_refusal() const;

 private:
  void run() noexcept;
  int poll_once() noexcept;
  void serve_round() noexcept;
  void accept_clients(MonoTime now) noexcept;
  void note_refused(const sockaddr_storage& peer, const char* why) noexcept;
  bool make_room(MonoTime now) noexcept;
  void drop(std::size_t index) noexcept;
  void drop_expired(MonoTime now) noexcept;

  RegisterBank& bank_;
  const ModbusTcpOptions options_;
  const PeerFilter filter_;
  FileDescriptor listener_;
  std::uint16_t port_ = 0;
  WakeUp stop_;

  std::vector<pollfd> polled_;  // stop, listener, then the clients in their order; the thread's own
  MonoTime accept_again_at_{};  // the system was out of descriptors

  mutable std::mutex mutex_;  // guards the clients and who was refused last; never held while waiting
  std::vector<std::unique_ptr<TcpConnection>> clients_;
  sockaddr_storage last_refused_{};
  const char* why_refused_ = "";
  std::thread thread_;
};

/// Whether TcpServer could listen there; binds the address for an instant.
/// \error  kIo with errno: EADDRINUSE: somebody listens there already, EADDRNOTAVAIL: no interface has it, EINVAL: it
/// is
///         no address
Result<void> try_listen(const std::string& address, std::uint16_t port) noexcept;

}  // namespace ninedot
