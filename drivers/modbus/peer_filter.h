#pragma once
/// Which addresses may connect.
#include <sys/socket.h>

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace ninedot {

class PeerFilter {
 public:
  /// \param allow  "192.168.1.7", "192.168.1.0/24", "fd00::/8"; empty = everybody
  /// Throws StartupError(kWrongUsage) naming the entry that is no address.
  explicit PeerFilter(const std::vector<std::string>& allow);
  bool allows(const sockaddr_storage& peer) const noexcept;

 private:
  using Address = std::array<std::uint8_t, 16>;  // IPv4 as ::ffff:a.b.c.d, as a dual-stack socket shows it
  struct Network {
    Address address;
    unsigned prefix_bits;
  };
  static Network parse(const std::string& entry);
  static bool contains(const Network& network, const Address& address) noexcept;
  std::vector<Network> networks_;
};

/// "127.0.0.1:40012", "[::1]:40012"; IPv4 in IPv6's clothes shows as IPv4.
std::string peer_text(const sockaddr_storage& peer);

}  // namespace ninedot
