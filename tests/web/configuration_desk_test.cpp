#include "programs/web/configuration_desk.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "config/config_reference.h"
#include "programs/web/large_body.h"
#include "tests/web/applier.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

class ConfigurationDeskTest : public testing::Test {
 protected:
  ConfigurationDeskTest() {
    std::string pattern = (fs::temp_directory_path() / "ninedot-test-XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr) std::abort();
    folder_ = pattern;
    file_ = (folder_ / "ninedot.toml").string();
    socket_ = (folder_ / "socket").string();
    std::ofstream(file_) << "old";
  }
  ~ConfigurationDeskTest() override { fs::remove_all(folder_); }

  static std::string tag_in(const std::string& json) {
    const std::size_t at = json.find("\"tag\":\"") + 7;
    return json.substr(at, json.find('"', at) - at);
  }
  static std::string ended(const ConfigurationDesk& desk) {
    for (;;) {
      const std::string json = desk.apply_json();
      if (json.find("\"state\":\"running\"") == std::string::npos) return json;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
  }
  static bool has(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

  fs::path folder_;
  std::string file_, socket_;
};

TEST_F(ConfigurationDeskTest, ChecksByLineAsTheServiceWould) {
  ApplyRequest request(socket_);
  const ConfigurationDesk desk(file_, request);
  const std::string wrong = desk.check_json("[camera]\nrate_hz = 0\n\"\\u0001\" = 1\n");
  EXPECT_TRUE(has(wrong, R"("line":2,"what":"'rate_hz' is 0; write)")) << wrong;
  EXPECT_TRUE(has(wrong, R"("count":2)")) << wrong;
  EXPECT_TRUE(has(desk.check_json("[camera\n"), R"("line":1)"));
  std::string many;
  for (int i = 0; i < 1000; ++i) many += fmt::format("k{} = 1\n", i);
  const std::string told = desk.check_json(many);  // and no recording is named
  EXPECT_TRUE(has(told, R"("count":1001)"));
  EXPECT_TRUE(has(told, R"("line":199,)"));
  EXPECT_FALSE(has(told, R"("line":200,)"));
}

TEST_F(ConfigurationDeskTest, HandsOverTheTextWithItsLengthAndTellsHowItEnded) {
  for (const auto& [answer, state] :
       {std::pair{"checking: x\nup: it runs\n", "up"}, std::pair{"checking: x\nrefused: x:1: no\n", "refused"},
        std::pair{"returning: a\nback: b\n", "back"}, std::pair{"unchanged: x\n", "unchanged"},
        std::pair{"failed: disk\n", "failed"}, std::pair{"checking: and then it dies", "failed"},
        std::pair{"", "failed"}}) {
    fs::remove(socket_);
    test::Applier applier(socket_, answer);
    ApplyRequest request(socket_);
    ConfigurationDesk desk(file_, request);
    applier.serve(11);
    const DeskReply reply = desk.apply("new", tag_in(desk.file_json(true)), true);
    EXPECT_EQ(reply.status, 202U) << reply.text;
    EXPECT_EQ(applier.heard(), "apply 3\nnew");
    if (std::string_view(state) == "failed") applier.hang_up();  // the others have said how it ended
    const std::string json = ended(desk);
    EXPECT_TRUE(has(json, fmt::format(R"("state":"{}")", state))) << json;
    EXPECT_FALSE(request.takes_new_file(mono_now())) << "its page has not heard of it yet";
    EXPECT_EQ(request.takes_new_file(mono_now() + std::chrono::seconds(10)), std::string_view(state) == "up");
    EXPECT_FALSE(request.takes_new_file(mono_now() + std::chrono::seconds(10))) << "once";
  }
}

TEST_F(ConfigurationDeskTest, AppliesNothingWhereItMayNotOrTheFileIsAnotherOne) {
  ApplyRequest request(socket_);
  ConfigurationDesk desk(file_, request);
  const std::string tag = tag_in(desk.file_json(true));
  EXPECT_EQ(desk.apply("new", tag, true).status, 403U) << "nobody listens";
  const test::Applier applier(socket_, "");
  EXPECT_EQ(desk.apply("new", tag, false).status, 403U) << "no token";
  EXPECT_EQ(desk.apply("new", "0123456789abcdef", true).status, 412U);
  std::ofstream(file_) << "by hand";
  EXPECT_EQ(desk.apply("new", tag, true).status, 412U);
  EXPECT_TRUE(has(desk.apply_json(), R"("state":"none")"));
}

TEST_F(ConfigurationDeskTest, BeginsOneAtATimeAndEndsWithoutWaitingForIt) {
  const test::Applier applier(socket_, "");
  const auto started = std::chrono::steady_clock::now();
  {
    ApplyRequest request(socket_);
    ConfigurationDesk desk(file_, request);
    const std::string tag = tag_in(desk.file_json(true));
    EXPECT_EQ(desk.apply("new", tag, true).status, 202U);
    EXPECT_EQ(desk.apply("new", tag, true).status, 409U);
  }
  EXPECT_LT(std::chrono::steady_clock::now() - started, std::chrono::seconds(5));
}

TEST_F(ConfigurationDeskTest, TellsTheOneBefore) {
  ApplyRequest request(socket_);
  const ConfigurationDesk desk(file_, request);
  EXPECT_TRUE(has(desk.file_json(true), R"("before":null)"));
  std::ofstream(file_ + ".before") << "older";
  EXPECT_TRUE(has(desk.file_json(true), R"("text":"old","problem":"")"));
  EXPECT_TRUE(has(desk.file_json(true), R"("before":"older")"));
}

TEST(ConfigurationKeys, AreThoseOfTheReference) {
  const std::string json = configuration_keys_json();
  for (const ConfigKey& key : config_keys())
    EXPECT_NE(json.find(fmt::format(R"("table":"{}","name":"{}")", key.table, key.name)), std::string::npos)
        << key.table << key.name;
}

TEST(LargeBody, IsOfOneAtATimeAndNoLongerThanItIs) {
  LargeBody body;
  const int one = 0, two = 0;
  ASSERT_TRUE(body.take(&one));
  EXPECT_FALSE(body.take(&two));
  EXPECT_TRUE(body.append(std::string(kMostLargeBody_bytes, 'x')));
  EXPECT_FALSE(body.append("x"));
  body.give_back(&two);
  EXPECT_TRUE(body.is_of(&one));
  body.give_back(&one);
  EXPECT_TRUE(body.take(&two));
  EXPECT_EQ(body.text(), "");
}

}  // namespace
}  // namespace ninedot
