#include "drivers/posix/service_manager.h"

#include <gtest/gtest.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <string>

namespace ninedot {
namespace {

using namespace std::chrono_literals;

/// Stands where systemd would listen (sd_notify(3): datagrams on $NOTIFY_SOCKET).
class NotifySocket {
 public:
  NotifySocket() : fd_(socket(AF_UNIX, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string name = "@ninedot-test-" + std::to_string(getpid());
    std::memcpy(address.sun_path, name.data(), name.size());
    address.sun_path[0] = '\0';
    const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size());
    EXPECT_EQ(bind(fd_, reinterpret_cast<const sockaddr*>(&address), length), 0);
    setenv("NOTIFY_SOCKET", name.c_str(), 1);
    setenv("WATCHDOG_USEC", "1000000", 1);
    unsetenv("WATCHDOG_PID");
  }
  ~NotifySocket() {
    close(fd_);
    unsetenv("NOTIFY_SOCKET");
    unsetenv("WATCHDOG_USEC");
  }
  std::string receive() const {
    char text[256];
    const ssize_t length = recv(fd_, text, sizeof text, 0);
    return length > 0 ? std::string(text, static_cast<std::size_t>(length)) : std::string();
  }

 private:
  int fd_;
};

TEST(ServiceManager, SaysReadyOnce) {
  const NotifySocket socket;
  ServiceManager manager;
  manager.ready();
  manager.ready();
  EXPECT_EQ(socket.receive(), "READY=1");
  EXPECT_EQ(socket.receive(), "");
}

TEST(ServiceManager, FeedsTheWatchdogOnlyWhileFramesAdvance) {
  const NotifySocket socket;
  ServiceManager manager;
  const MonoTime t = mono_now();
  EXPECT_TRUE(manager.feed_watchdog(1, t));
  EXPECT_EQ(socket.receive(), "WATCHDOG=1");
  EXPECT_FALSE(manager.feed_watchdog(2, t + 100ms)) << "at most four times per interval";
  EXPECT_TRUE(manager.feed_watchdog(2, t + 300ms));
  EXPECT_FALSE(manager.feed_watchdog(2, t + 10s)) << "no progress, no food";
  EXPECT_TRUE(manager.feed_watchdog(3, t + 20s));
}

TEST(ServiceManager, DoesNothingWithoutAServiceManager) {
  unsetenv("NOTIFY_SOCKET");
  unsetenv("WATCHDOG_USEC");
  ServiceManager manager;
  manager.ready();
  EXPECT_FALSE(manager.feed_watchdog(1, mono_now()));
}

}  // namespace
}  // namespace ninedot
