#include "programs/commands/service_client.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <thread>

#include "base/startup_error.h"
#include "drivers/posix/file_descriptor.h"
#include "programs/commands/commands.h"
#include "tests/programs/typed_command.h"

namespace ninedot {
namespace {

/// One that speaks something else: it answers a client's first request with `answer`.
class OtherServer {
 public:
  explicit OtherServer(std::string answer) : listener_(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    at_.sin_family = AF_INET;
    at_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof at_;
    EXPECT_EQ(::bind(listener_.get(), reinterpret_cast<const sockaddr*>(&at_), size), 0);
    EXPECT_EQ(::listen(listener_.get(), 1), 0);
    EXPECT_EQ(::getsockname(listener_.get(), reinterpret_cast<sockaddr*>(&at_), &size), 0);
    thread_ = std::thread([this, text = std::move(answer)] {
      const FileDescriptor client(::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC));
      std::array<char, 12> request{};
      EXPECT_EQ(::recv(client.get(), request.data(), request.size(), MSG_WAITALL), 12);
      EXPECT_GT(::send(client.get(), text.data(), text.size(), MSG_NOSIGNAL), 0);
      EXPECT_EQ(::recv(client.get(), request.data(), 1, 0), 0) << "until the client has gone";
    });
  }
  ~OtherServer() { thread_.join(); }
  OtherServer(const OtherServer&) = delete;
  OtherServer& operator=(const OtherServer&) = delete;
  std::uint16_t port() const { return ntohs(at_.sin_port); }

 private:
  FileDescriptor listener_;
  sockaddr_in at_{};
  std::thread thread_;
};

/// What reading a server that answers so is refused with, behind its place.
std::string refusal_of(const std::string& answer) {
  const OtherServer server(answer);
  ServiceClient client("127.0.0.1", server.port());
  try {
    static_cast<void>(client.read());
  } catch (const StartupError& error) {
    return std::string(error.what()).substr(client.place().size());
  }
  return "no error";
}

TEST(ServiceClient, SaysWhatIsWrongWithAnAnswerAndNothingElse) {
  using std::string_literals::operator""s;
  EXPECT_EQ(refusal_of("\0\1\0\0\0\5\xff\3\2\0\0"s), ": the server's answer is no valid Modbus reply");
  EXPECT_EQ(refusal_of("\0\1\0\0\0\3\xff\x83\4"s), ": the server refused the request with a Modbus exception");
}

TEST(ServiceClient, SaysThatAHostIsNotKnownAndNotThatItRefused) {
  try {
    const ServiceClient client("nowhere.invalid", 1502);
    ADD_FAILURE() << "there is no such host";
  } catch (const StartupError& error) {
    EXPECT_STREQ(error.what(),
                 "--host nowhere.invalid: no address is known for this name: check it, or give the address in numbers, "
                 "as 192.168.1.20");
  }
}

TEST(ServiceClient, IsNotAskedOfAHostWithoutAName) {
  for (const auto& [add, command] : {std::pair{&add_status_command, "status"}, {&add_aim_command, "aim"}}) try {
      test::type_command(add, {command, "--host", ""});
      ADD_FAILURE() << command;
    } catch (const CLI::ParseError& error) {
      EXPECT_STREQ(error.what(), "--host: names nothing: give it a name, or leave it out");
    }
}

}  // namespace
}  // namespace ninedot
