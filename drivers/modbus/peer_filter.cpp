#include "drivers/modbus/peer_filter.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>

#include <algorithm>
#include <charconv>
#include <cstring>
#include <string_view>

#include "base/startup_error.h"

namespace ninedot {
namespace {

constexpr std::array<std::uint8_t, 12> kMappedPrefix = {0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0xFF, 0xFF};

std::array<std::uint8_t, 16> mapped(const in_addr& v4) noexcept {
  std::array<std::uint8_t, 16> address{};
  std::copy(kMappedPrefix.begin(), kMappedPrefix.end(), address.begin());
  std::memcpy(address.data() + kMappedPrefix.size(), &v4, sizeof v4);
  return address;
}

std::array<std::uint8_t, 16> address_of(const sockaddr_storage& peer) noexcept {
  if (peer.ss_family == AF_INET) {
    sockaddr_in v4;
    std::memcpy(&v4, &peer, sizeof v4);
    return mapped(v4.sin_addr);
  }
  sockaddr_in6 v6;
  std::memcpy(&v6, &peer, sizeof v6);
  std::array<std::uint8_t, 16> address;
  std::memcpy(address.data(), &v6.sin6_addr, address.size());
  return address;
}

}  // namespace

PeerFilter::PeerFilter(const std::vector<std::string>& allow) {
  for (const std::string& entry : allow) networks_.push_back(parse(entry));
}

PeerFilter::Network PeerFilter::parse(const std::string& entry) {
  const std::size_t slash = entry.find('/');
  const std::string host = entry.substr(0, slash);
  Network network{};
  unsigned host_bits = 128;
  in_addr v4;
  if (::inet_pton(AF_INET, host.c_str(), &v4) == 1) {
    network.address = mapped(v4);
    host_bits = 32;
  } else if (::inet_pton(AF_INET6, host.c_str(), network.address.data()) != 1) {
    throw StartupError(
        ExitStatus::kWrongUsage,
        fmt::format("'{}' in the list of allowed Modbus clients is no address: write one like 192.168.1.7 or "
                    "192.168.1.0/24",
                    entry));
  }
  unsigned bits = host_bits;
  if (slash != std::string::npos) {
    const std::string_view text = std::string_view(entry).substr(slash + 1);
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), bits);
    if (error != std::errc{} || end != text.data() + text.size() || bits > host_bits)
      throw StartupError(
          ExitStatus::kWrongUsage,
          fmt::format("'{}' in the list of allowed Modbus clients: the prefix must be 0 to {}", entry, host_bits));
  }
  network.prefix_bits = 128 - host_bits + bits;
  return network;
}

bool PeerFilter::contains(const Network& network, const Address& address) noexcept {
  const std::size_t whole = network.prefix_bits / 8;
  if (!std::equal(network.address.begin(), network.address.begin() + static_cast<std::ptrdiff_t>(whole),
                  address.begin()))
    return false;
  const unsigned rest = network.prefix_bits % 8;
  if (rest == 0) return true;
  return (network.address[whole] ^ address[whole]) >> (8U - rest) == 0;
}

bool PeerFilter::allows(const sockaddr_storage& peer) const noexcept {
  if (networks_.empty()) return true;
  const Address address = address_of(peer);
  return std::any_of(networks_.begin(), networks_.end(), [&](const Network& n) { return contains(n, address); });
}

std::string peer_text(const sockaddr_storage& peer) {
  const std::array<std::uint8_t, 16> address = address_of(peer);
  std::array<char, INET6_ADDRSTRLEN> text{};
  const bool is_v4 = std::equal(kMappedPrefix.begin(), kMappedPrefix.end(), address.begin());
  ::inet_ntop(is_v4 ? AF_INET : AF_INET6, address.data() + (is_v4 ? kMappedPrefix.size() : 0), text.data(),
              text.size());
  // The port stands at the same place in both structures.
  static_assert(offsetof(sockaddr_in, sin_port) == offsetof(sockaddr_in6, sin6_port));
  sockaddr_in any;
  std::memcpy(&any, &peer, sizeof any);
  return fmt::format(fmt::runtime(is_v4 ? "{}:{}" : "[{}]:{}"), text.data(), ntohs(any.sin_port));
}

}  // namespace ninedot
