#include "programs/web/access.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <future>

#include "base/startup_error.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

const std::string kToken = "0123456789abcdef0123456789abcdef";

RequestHead looking_at(std::string_view path) {
  RequestHead head;
  head.method = "GET";
  head.path = path;
  head.host = "127.0.0.1:8090";
  head.peer = "10.0.0.7";
  return head;
}

Access open_access() { return Access(AccessRules{}); }
Access guarded_access() { return Access(AccessRules{kToken, {"sensor7"}, false}); }

TEST(WebAccess, LetsLookWhoeverMayConnectWithoutAToken) {
  Access access = open_access();
  for (const char* path : {"/", "/api/live", "/api/map"}) EXPECT_EQ(access.refusal_of(looking_at(path), {}).status, 0U);
}

TEST(WebAccess, AnswersNoMethodThatCouldChangeAnything) {
  Access access = open_access();
  for (const char* method : {"POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "CONNECT", "get", ""}) {
    RequestHead head = looking_at("/");
    head.method = method;
    EXPECT_EQ(access.refusal_of(head, {}).status, 405U) << method;
  }
}

TEST(WebAccess, TakesNoBody) {
  Access access = open_access();
  RequestHead head = looking_at("/");
  head.content_length = "1000000000000";
  EXPECT_EQ(access.refusal_of(head, {}).status, 413U);
  head.content_length = "0";
  EXPECT_EQ(access.refusal_of(head, {}).status, 0U);
  head.transfer_encoding = "chunked";
  EXPECT_EQ(access.refusal_of(head, {}).status, 413U);
}

TEST(WebAccess, KnowsItselfByAddressesAndItsOwnNamesAlone) {
  Access access = guarded_access();
  for (const char* host :
       {"localhost:8090", "127.0.0.1", "[::1]:8090", "192.168.1.5:8090", "sensor7", "sensor7:8090", "Sensor7"}) {
    RequestHead head = looking_at("/");
    head.host = host;
    EXPECT_EQ(access.refusal_of(head, {}).status, 0U) << host;
  }
  for (const char* host : {"", "evil.example", "evil.example:8090", "localhost.evil.example", "sensor7.evil.example",
                           "127.0.0.1.evil.example", "[", "[]"}) {
    RequestHead head = looking_at("/");
    head.host = host;
    EXPECT_EQ(access.refusal_of(head, {}).status, 421U) << host;
  }
}

TEST(WebAccess, AnswersNoOtherPage) {
  Access access = open_access();
  RequestHead head = looking_at("/api/live");
  for (const char* origin : {"http://evil.example", "null", "https://127.0.0.1:8090", "http://127.0.0.1:8091"}) {
    head.origin = origin;
    EXPECT_EQ(access.refusal_of(head, {}).status, 403U) << origin;
  }
  head.origin = "http://127.0.0.1:8090";
  EXPECT_EQ(access.refusal_of(head, {}).status, 0U);
  head.fetch_site = "cross-site";
  EXPECT_EQ(access.refusal_of(head, {}).status, 403U);
}

TEST(WebAccess, AsksForTheTokenWhereItIsSet) {
  Access access = guarded_access();
  RequestHead head = looking_at("/api/live");
  EXPECT_EQ(access.refusal_of(head, {}).status, 401U);
  const std::string right = "Bearer " + kToken, wrong = "Bearer " + kToken + "0", other = "Basic " + kToken;
  head.authorization = right;
  EXPECT_EQ(access.refusal_of(head, {}).status, 0U);
  head.authorization = wrong;
  EXPECT_EQ(access.refusal_of(head, {}).status, 401U);
  head.authorization = other;
  EXPECT_EQ(access.refusal_of(head, {}).status, 401U);
  EXPECT_EQ(access.refusal_of(looking_at("/"), {}).status, 0U) << "the page itself is no secret";
  EXPECT_EQ(access.refusal_of(looking_at("/api/session"), {}).status, 0U);
}

RequestHead changing(std::string_view path = "/api/aim") {
  RequestHead head = looking_at(path);
  static const std::string kBearer = "Bearer " + kToken;
  head.method = "POST";
  head.origin = "http://127.0.0.1:8090";
  head.fetch_site = "same-origin";
  head.authorization = kBearer;
  head.content_length = "20";
  return head;
}

TEST(WebAccess, LetsThePageItselfChangeSomethingWithTheToken) {
  Access access = guarded_access();
  for (const char* path : {"/api/aim", "/api/recordings", "/api/calibrate", "/api/map/build"})
    EXPECT_EQ(access.refusal_of(changing(path), {}).status, 0U) << path;
  RequestHead older = changing();
  older.fetch_site = "";
  EXPECT_EQ(access.refusal_of(older, {}).status, 0U) << "a browser that does not send it, or no TLS";
}

TEST(WebAccess, TakesALongBodyWhereOneIsExpected) {
  Access access = guarded_access();
  RequestHead head = changing();
  for (const char* path : {"/api/configuration/check", "/api/configuration/apply"}) {
    head.path = path;
    head.content_length = "262144";
    EXPECT_EQ(access.refusal_of(head, {}).status, 0U) << path;
    head.content_length = "262145";
    EXPECT_EQ(access.refusal_of(head, {}).status, 413U) << path;
  }
  head.path = "/api/map/build";
  head.content_length = "6144";
  EXPECT_EQ(access.refusal_of(head, {}).status, 0U) << "the names of 200 recordings";
  head.content_length = "6145";
  EXPECT_EQ(access.refusal_of(head, {}).status, 413U);
  head.path = "/api/aim";
  head.content_length = "129";
  EXPECT_EQ(access.refusal_of(head, {}).status, 413U);
  head.path = "/api/configuration";
  EXPECT_EQ(access.refusal_of(head, {}).status, 405U) << "there is nothing to post to";
}

TEST(WebAccess, ChecksWithoutATokenWhereNoneIsSetButForNoOtherPage) {
  Access open = open_access();
  RequestHead head = changing();
  head.authorization = "";
  head.path = "/api/configuration/apply";
  EXPECT_EQ(open.refusal_of(head, {}).status, 403U);
  head.path = "/api/configuration/check";
  EXPECT_EQ(open.refusal_of(head, {}).status, 0U);
  head.origin = "";
  EXPECT_EQ(open.refusal_of(head, {}).status, 403U);
  head.origin = "http://127.0.0.1:8090";
  Access guarded = guarded_access();
  EXPECT_EQ(guarded.refusal_of(head, {}).status, 401U);
}

TEST(WebAccess, ChangesNothingWithoutAToken) {
  Access guarded = guarded_access();
  for (const char* path : {"/api/aim", "/api/recordings", "/api/calibrate", "/api/map/build"}) {
    RequestHead unknown = changing(path);
    unknown.authorization = "";
    EXPECT_EQ(guarded.refusal_of(unknown, {}).status, 401U) << path;
    EXPECT_EQ(open_access().refusal_of(unknown, {}).status, 403U) << path;
  }
  RequestHead head = changing();
  head.authorization = "Bearer guess";
  EXPECT_EQ(guarded.refusal_of(head, {}).status, 401U);
  Access open = open_access();
  for (const char* given : {"", "Bearer ", "Bearer guess"}) {
    head.authorization = given;
    EXPECT_EQ(open.refusal_of(head, {}).status, 403U) << "on this machine neither";
  }
}

TEST(WebAccess, ChangesNothingForOtherPages) {
  Access access = guarded_access();
  for (const char* path : {"/api/aim", "/api/recordings", "/api/calibrate", "/api/map/build"})
    for (const char* origin : {"", "null", "http://evil.example", "https://127.0.0.1:8090", "http://127.0.0.1:8091",
                               "http://127.0.0.1", "http://127.0.0.1:8090.evil.example", "http://localhost:8090"}) {
      RequestHead head = changing(path);
      head.origin = origin;
      EXPECT_EQ(access.refusal_of(head, {}).status, 403U) << path << origin;
    }
  for (const char* site : {"cross-site", "same-site", "none", "something new"}) {
    RequestHead head = changing();
    head.fetch_site = site;
    EXPECT_EQ(access.refusal_of(head, {}).status, 403U) << site;
  }
  RequestHead rebound = changing();
  rebound.host = "evil.example";
  rebound.origin = "http://evil.example";
  EXPECT_EQ(access.refusal_of(rebound, {}).status, 421U);
}

TEST(WebAccess, ChangesSomethingAtItsPathsByOneMethod) {
  Access access = guarded_access();
  for (const char* path : {"/", "/api/live", "/api/map", "/api/aim/", "/api/aim2", "/API/AIM", "//api/aim",
                           "/api/recordings/", "/api/recordings/20261123-121415-asked/download"}) {
    RequestHead head = changing();
    head.path = path;
    EXPECT_EQ(access.refusal_of(head, {}).status, 405U) << path;
  }
  for (const char* method : {"PUT", "DELETE", "PATCH", "OPTIONS", "post"}) {
    RequestHead head = changing();
    head.method = method;
    EXPECT_EQ(access.refusal_of(head, {}).status, 405U) << method;
  }
  for (const char* path : {"/api/aim", "/api/recordings", "/api/recordings/20261123-121415-asked/download"})
    EXPECT_EQ(access.refusal_of(looking_at(path), {}).status, 401U) << "who looks needs the token as ever: " << path;
}

TEST(WebAccess, TakesAShortBodyOfAToldLength) {
  Access access = guarded_access();
  const auto status = [&](const char* length, const char* encoding) {
    RequestHead head = changing();
    head.content_length = length;
    head.transfer_encoding = encoding;
    return access.refusal_of(head, {}).status;
  };
  EXPECT_EQ(status("128", ""), 0U);
  EXPECT_EQ(status("0", ""), 0U) << "understood, and answered as nothing";
  for (const char* length : {"129", "1000000000000", "99999999999999999999999999", "-1", "0x10", "12 ", "+5", "1e3"})
    EXPECT_EQ(status(length, ""), 413U) << length;
  EXPECT_EQ(status("", ""), 411U);
  EXPECT_EQ(status("20", "chunked"), 411U);
  EXPECT_EQ(status("", "chunked"), 411U);
}

TEST(WebAccess, AClosedDoorIsClosedForChangesAsWell) {
  Access access = guarded_access();
  RequestHead guessing = changing();
  guessing.authorization = "Bearer guess";
  for (int i = 0; i < TokenGate::kMaxWrong; ++i) EXPECT_EQ(access.refusal_of(guessing, {}).status, 401U);
  EXPECT_EQ(access.refusal_of(changing(), {}).status, 429U);
}

TEST(WebAccess, LooksAtNoTokenAfterFiveWrongOnesFromThereForAMinute) {
  Access access = guarded_access();
  const MonoTime start{};
  RequestHead guessing = looking_at("/api/live");
  guessing.authorization = "Bearer guess";
  for (int i = 0; i < TokenGate::kMaxWrong; ++i) EXPECT_EQ(access.refusal_of(guessing, start + 1s * i).status, 401U);
  const std::string right = "Bearer " + kToken;
  guessing.authorization = right;
  EXPECT_EQ(access.refusal_of(guessing, start + 59s).status, 429U);
  EXPECT_TRUE(access.refusal_of(guessing, start + 59s).retry_later);
  RequestHead other = guessing;
  other.peer = "10.0.0.8";
  EXPECT_EQ(access.refusal_of(other, start + 59s).status, 0U) << "somebody else's mistakes are not his";
  EXPECT_EQ(access.refusal_of(guessing, start + 61s).status, 0U);
}

TEST(WebAccess, ForgetsNoGuesserBecauseOthersMadeOneMistake) {
  TokenGate gate;
  const MonoTime start{1s};
  for (int i = 0; i < 5; ++i) gate.note_wrong("10.0.0.7", start);
  for (int i = 0; i < 200; ++i) gate.note_wrong("10.0.1." + std::to_string(i), start + 1s);
  EXPECT_TRUE(gate.is_closed_for("10.0.0.7", start + 2s));
}

TEST(WebAccess, ComparesSecretsByAllOfThem) {
  EXPECT_TRUE(is_same_secret("abc", "abc"));
  for (const char* wrong : {"", "ab", "abcd", "abd", "bbc", "ABC"}) EXPECT_FALSE(is_same_secret(wrong, "abc")) << wrong;
  EXPECT_FALSE(is_same_secret(std::string_view("abc\0", 4), "abc"));
}

TEST(WebToken, IsReadFromAFileOfItsOwnerAlone) {
  const std::string file = testing::TempDir() + "ninedot-token";
  const auto refusal = [&](const std::string& text, unsigned mode) -> std::string {
    std::filesystem::remove(file);
    std::ofstream(file) << text;
    ::chmod(file.c_str(), mode);
    try {
      EXPECT_EQ(read_token(file), kToken);
    } catch (const StartupError& error) {
      EXPECT_EQ(error.status, ExitStatus::kWrongUsage);
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refusal(kToken + "\n", 0600), "");
  EXPECT_EQ(refusal(kToken, 0400), "");
  EXPECT_NE(refusal(kToken + "\n", 0640).find("chmod 600"), std::string::npos);
  EXPECT_NE(refusal(kToken + "\n", 0604).find("chmod 600"), std::string::npos);
  EXPECT_NE(refusal("short\n", 0600).find("32 to 500"), std::string::npos);
  EXPECT_NE(refusal("", 0600).find("32 to 500"), std::string::npos);
  EXPECT_NE(refusal(kToken + "\nand a second line\n", 0600).find("one line"), std::string::npos);
  EXPECT_NE(refusal(std::string(600, 'x'), 0600).find("32 to 500"), std::string::npos);
  std::filesystem::remove(file);
  EXPECT_THROW(read_token(file), StartupError);
}

TEST(WebAccess, AFifoThatNobodyWritesToIsNoToken) {
  const std::string file =
      (std::filesystem::temp_directory_path() / ("ninedot-fifo-" + std::to_string(::getpid()))).string();
  ASSERT_EQ(::mkfifo(file.c_str(), 0600), 0);
  std::string refusal;
  auto reading = std::async(std::launch::async, [&] {
    try {
      static_cast<void>(read_token(file));
    } catch (const StartupError& error) {
      refusal = error.what();
    }
  });
  while (reading.wait_for(10s) != std::future_status::ready) {
    ADD_FAILURE() << "waits without end";
    ::close(::open(file.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC));
  }
  EXPECT_EQ(refusal, file + ": the token can't be read: is a pipe that nobody writes to");
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace ninedot
