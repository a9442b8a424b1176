#include "programs/web/web_server.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <optional>

#include "base/startup_error.h"
#include "drivers/posix/file_descriptor.h"
#include "programs/web/calibration_desk.h"
#include "programs/web/child_job.h"
#include "programs/web/configuration_desk.h"
#include "programs/web/jogger.h"
#include "programs/web/map_desk.h"
#include "programs/web/recorder.h"

namespace ninedot {
namespace {

sockaddr_in loopback(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  return address;
}

std::uint16_t free_port() {
  const FileDescriptor probe(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in address = loopback(0);
  socklen_t size = sizeof address;
  EXPECT_EQ(::bind(probe.get(), reinterpret_cast<const sockaddr*>(&address), size), 0);
  EXPECT_EQ(::getsockname(probe.get(), reinterpret_cast<sockaddr*>(&address), &size), 0);
  return ntohs(address.sin_port);
}

/// One ninedot-web, at a port.
class Page {
 public:
  explicit Page(std::uint16_t port) {
    Config config;
    config.web.listen = "127.0.0.1";
    config.web.port = port;
    server_.emplace(WebServerOptions{
        config.web, "/no/tap", {}, [] { return "[]"; }, jogger_, recorder_, desk_, calibrations_, maps_});
  }

 private:
  Jogger jogger_{jogger_options(Config{}, false)};
  Recorder recorder_{recorder_options(Config{}, false)};
  ApplyRequest request_{"/no/socket"};
  ChildJob job_{"/no/program"};
  ConfigurationDesk desk_{"/no/config", request_};
  CalibrationDesk calibrations_{calibration_desk_options(Config{}, "/no/config", false), job_, request_};
  MapDesk maps_{map_desk_options(Config{}, "/no/config", false), job_, request_};
  std::optional<WebServer> server_;
};

FileDescriptor connect_to(std::uint16_t port) {
  FileDescriptor socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  const sockaddr_in address = loopback(port);
  EXPECT_EQ(::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address), 0);
  return socket;
}

TEST(WebServer, ASecondOneAtAPortIsRefused) {
  const std::uint16_t port = free_port();
  const Page first(port);
  try {
    const Page second(port);
    ADD_FAILURE() << "both serve";
  } catch (const StartupError& error) {
    EXPECT_EQ(error.status, ExitStatus::kWorkFailed);
    EXPECT_EQ(error.what(), "127.0.0.1 port " + std::to_string(port) + " can't be served: Address already in use");
  }
}

TEST(WebServer, ServesAtOnceWhereOneHasStoppedThatHadClients) {
  const std::uint16_t port = free_port();
  FileDescriptor client;
  {
    const Page first(port);
    client = connect_to(port);
    constexpr std::string_view kRequest = "GET / HTTP/1.1\r\nHost: localhost\r\n\r\n";
    EXPECT_EQ(::send(client.get(), kRequest.data(), kRequest.size(), MSG_NOSIGNAL), ssize_t{kRequest.size()});
    char byte = 0;
    EXPECT_EQ(::recv(client.get(), &byte, 1, 0), 1);
  }
  // The server has closed first, and the kernel keeps its end for a minute.
  const Page second(port);
  EXPECT_TRUE(connect_to(port));
}

}  // namespace
}  // namespace ninedot
