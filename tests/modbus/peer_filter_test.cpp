#include "drivers/modbus/peer_filter.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>

#include <cstring>

#include "base/startup_error.h"

namespace ninedot {
namespace {

sockaddr_storage peer(const char* address, std::uint16_t port = 502) {
  sockaddr_storage storage{};
  sockaddr_in v4{};
  sockaddr_in6 v6{};
  if (::inet_pton(AF_INET, address, &v4.sin_addr) == 1) {
    v4.sin_family = AF_INET;
    v4.sin_port = htons(port);
    std::memcpy(&storage, &v4, sizeof v4);
  } else if (::inet_pton(AF_INET6, address, &v6.sin6_addr) == 1) {
    v6.sin6_family = AF_INET6;
    v6.sin6_port = htons(port);
    std::memcpy(&storage, &v6, sizeof v6);
  }
  return storage;
}

TEST(PeerFilter, AnEmptyListAllowsEverybody) { EXPECT_TRUE(PeerFilter({}).allows(peer("203.0.113.9"))); }

TEST(PeerFilter, AnAddressAllowsItselfAlone) {
  const PeerFilter filter({"192.168.1.7"});
  EXPECT_TRUE(filter.allows(peer("192.168.1.7")));
  EXPECT_TRUE(filter.allows(peer("::ffff:192.168.1.7"))) << "as a dual-stack socket shows it";
  EXPECT_FALSE(filter.allows(peer("192.168.1.8")));
  EXPECT_FALSE(filter.allows(peer("::1")));
}

TEST(PeerFilter, APrefixAllowsItsNetworkAndNoMore) {
  const PeerFilter filter({"10.20.16.0/20", "fd00:1::/33"});
  EXPECT_TRUE(filter.allows(peer("10.20.16.0")));
  EXPECT_TRUE(filter.allows(peer("10.20.31.255")));
  EXPECT_FALSE(filter.allows(peer("10.20.32.0")));
  EXPECT_FALSE(filter.allows(peer("10.20.15.255")));
  EXPECT_TRUE(filter.allows(peer("fd00:1:7fff::1")));
  EXPECT_FALSE(filter.allows(peer("fd00:1:8000::1")));
}

TEST(PeerFilter, PrefixZeroAllowsAllOfItsFamily) {
  EXPECT_TRUE(PeerFilter({"0.0.0.0/0"}).allows(peer("198.51.100.1")));
  EXPECT_FALSE(PeerFilter({"0.0.0.0/0"}).allows(peer("2001:db8::1")));
}

TEST(PeerFilter, WhatIsNoAddressIsNamedInTheError) {
  for (const char* entry :
       {"plc", "192.168.1.300", "192.168.1.0/33", "10.0.0.0/", "10.0.0.0/8x", "", "::/129", "10.0.0.0/-1"}) {
    try {
      const PeerFilter filter({entry});
      FAIL() << entry;
    } catch (const StartupError& error) {
      EXPECT_EQ(error.status, ExitStatus::kWrongUsage);
      EXPECT_NE(std::string(error.what()).find(std::string("'") + entry + "'"), std::string::npos);
    }
  }
}

TEST(PeerFilter, PeersAreShownAsPeopleWriteThem) {
  EXPECT_EQ(peer_text(peer("192.168.1.7", 40012)), "192.168.1.7:40012");
  EXPECT_EQ(peer_text(peer("::ffff:192.168.1.7", 40012)), "192.168.1.7:40012");
  EXPECT_EQ(peer_text(peer("::1", 40012)), "[::1]:40012");
}

}  // namespace
}  // namespace ninedot
