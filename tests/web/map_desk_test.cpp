// The map's desk as the page's process has it: what it understands, which words its child gets, and who has to wait.
#include "programs/web/map_desk.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <thread>

#include "programs/web/access.h"
#include "programs/web/calibration_desk.h"
#include "programs/web/map_request.h"
#include "tests/web/applier.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

constexpr const char* kFirst = "20261123-121415-asked";
constexpr const char* kSecond = "20261123-121503-loss";

TEST(MapRequest, HasItsOriginAndItsRecordings) {
  const auto request = parse_map_request("start 12 20261123-121415-asked 20261123-121503-loss");
  ASSERT_TRUE(request);
  EXPECT_EQ(request->origin, "12");
  EXPECT_FALSE(request->with_new);
  EXPECT_EQ(request->recordings, (std::vector<std::string_view>{kFirst, kSecond}));
  EXPECT_TRUE(parse_map_request("start measured new 20261123-121415-asked")->with_new);
  EXPECT_EQ(parse_map_request("start map 20261123-121415-asked")->origin, "map");
}

TEST(MapRequest, IsNothingElse) {
  for (const char* text : {"",
                           "start",
                           "start ",
                           "start 1",
                           "start 1 ",
                           "start 1 new",
                           "start 1 new ",
                           " start 1 20261123-121415-asked",
                           "start 1 20261123-121415-asked ",
                           "start  1 20261123-121415-asked",
                           "start 1  20261123-121415-asked",
                           "start 65536 20261123-121415-asked",
                           "start -1 20261123-121415-asked",
                           "start 1x 20261123-121415-asked",
                           "start --new 20261123-121415-asked",
                           "start 1 ../20261123-121415-asked",
                           "start 1 20261123-121415-asked/..",
                           "start 1 20261123-121415-asked 20261123-121415-asked",
                           "start 1 --config",
                           "start 1 new new 20261123-121415-asked",
                           "start 1\n20261123-121415-asked",
                           "begin 1 20261123-121415-asked",
                           "start 1 20261123-121415"})
    EXPECT_FALSE(parse_map_request(text)) << text;
}

TEST(MapRequest, OfTwoHundredRecordingsFitsIntoABody) {
  std::string text = "start measured new";
  for (int i = 0; i < 200; ++i) text += " 20261123-121415-asked";
  EXPECT_LE(text.size(), find_post_path("/api/map/build")->most_bytes);
}

class MapDeskTest : public testing::Test {
 protected:
  MapDeskTest() {
    std::string pattern = (fs::temp_directory_path() / "ninedot-test-XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr) std::abort();
    folder_ = pattern;
    options_.config_path = "/etc/ninedot/ninedot.toml";
    options_.map = "hall.toml";
    options_.folder = (folder_ / "maps").string();
    options_.has_token = true;
    options_.folder_of = [this](std::string_view name) {
      return fs::exists(folder_ / name) ? (folder_ / name).string() : std::string();
    };
    options_.landmarks = [] { return std::string(R"([{"id":1}])"); };
    fs::create_directories(folder_ / kFirst);
    fs::create_directories(folder_ / kSecond / "reports");
  }
  ~MapDeskTest() override { fs::remove_all(folder_); }

  /// In the place of `ninedot`. \param work  of the shell
  std::string program(const std::string& work) {
    const fs::path file = folder_ / "ninedot";
    std::ofstream(file) << "#!/bin/bash\necho \"$*\" > " << folder_.string() << "/words\n" << work << "\n";
    fs::permissions(file, fs::perms::owner_all);
    return file.string();
  }
  template <typename Desk>
  static std::string until(const Desk& desk, const std::string& words) {
    const auto give_up_at = std::chrono::steady_clock::now() + 20s;
    for (;;) {
      std::string json = desk.state_json();
      if (json.find(words) != std::string::npos || std::chrono::steady_clock::now() > give_up_at) return json;
      std::this_thread::sleep_for(5ms);
    }
  }
  static void expect_part(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
  }
  std::string words() const {
    std::ifstream stream(folder_ / "words");
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  std::size_t made() const {
    std::size_t count = 0;
    std::error_code none;
    for (fs::directory_iterator at(folder_ / "maps", none), end; at != end; ++at) ++count;
    return count;
  }
  static std::string start(const char* origin) { return std::string("start ") + origin + " " + kFirst; }

  fs::path folder_;
  MapDeskOptions options_;
  ApplyRequest request_{"/nonexistent/socket"};
};

constexpr const char* kReads = R"(echo '{"state":"reading","look":1}'; exec sleep 60)";
constexpr const char* kFinishes = R"(echo '{"state":"done","file":"x"}')";

TEST_F(MapDeskTest, StartsTheCommandWithTheRecordingsThatWereNamed) {
  ChildJob job(program(kFinishes));
  MapDesk desk(options_, job, request_);
  expect_part(desk.state_json(), R"("map":"hall.toml","config":"/etc/ninedot/ninedot.toml")");
  expect_part(desk.state_json(), R"("landmarks":[{"id":1}])");
  EXPECT_EQ(desk.reply_to(start("measured new") + " " + kSecond).status, 200U);
  expect_part(until(desk, R"("phase":"done")"), R"("of":"map","phase":"done","number":1)");
  const std::string folder = folder_.string();
  const std::string made_in = fs::directory_iterator(folder_ / "maps")->path().string();
  EXPECT_EQ(words(), "map " + folder + "/" + kFirst + " " + folder + "/" + kSecond +
                         " --config /etc/ninedot/ninedot.toml --origin measured --out " + made_in +
                         "/map.toml --plan " + made_in + "/plan.svg --new --progress json\n");
  EXPECT_EQ(desk.file_of(fs::path(made_in).filename().string() + "/plan.svg"), made_in + "/plan.svg");
  for (const char* path :
       {"", "20261123-121415/", "20261123-121415/camera.yaml", "../map.toml", "20261123-121415/../map.toml",
        "20261123-121415/map.toml.tmp", "20261123-121415-asked/map.toml"})
    EXPECT_EQ(desk.file_of(path), "") << path;
}

TEST_F(MapDeskTest, RefusesWhatIsNotThere) {
  ChildJob job(program(kFinishes));
  MapDesk desk(options_, job, request_);
  EXPECT_EQ(desk.reply_to("start 1 20200101-000000-asked").status, 404U);
  EXPECT_EQ(desk.reply_to("start 1 ../../etc").status, 400U);
  EXPECT_EQ(desk.reply_to("cancel").status, 409U);
  EXPECT_EQ(desk.reply_to("use ../x").status, 400U);
  EXPECT_EQ(desk.reply_to("use 20200101-000000").status, 409U) << "there is none";
  std::ofstream(folder_ / kSecond / "reports/000000.json") << R"({"number":0,"calibrated":false,"dots":[]})";
  const DeskReply reply = desk.reply_to(std::string("start 1 ") + kSecond);
  EXPECT_EQ(reply.status, 409U);
  expect_part(reply.text, "while the camera was not calibrated");
  EXPECT_EQ(made(), 0U);
  EXPECT_EQ(words(), "") << "no child was started";
}

TEST_F(MapDeskTest, WaitsForACalibrationAndACalibrationForIt) {
  ChildJob job(program(kReads));
  MapDesk desk(options_, job, request_);
  CalibrationDeskOptions other;
  other.config_path = "c", other.folder = (folder_ / "calibrations").string(), other.limits = "{}";
  CalibrationDesk calibrations(other, job, request_);
  EXPECT_EQ(desk.reply_to(start("1")).status, 200U);
  until(desk, "reading");
  EXPECT_EQ(desk.reply_to(start("1")).status, 409U);
  const DeskReply refused = calibrations.reply_to("start camera");
  EXPECT_EQ(refused.status, 409U);
  expect_part(refused.text, "A map is being built: cancel it first");
  EXPECT_EQ(calibrations.reply_to("cancel").status, 409U) << "it is not theirs";
  EXPECT_EQ(calibrations.reply_to("finish").status, 409U);
  EXPECT_EQ(desk.reply_to("cancel").status, 200U);
  expect_part(until(desk, R"("news":null)"), R"("phase":"cancelled")");
  EXPECT_EQ(calibrations.reply_to("start camera").status, 200U);
  until(calibrations, "reading");
  expect_part(desk.reply_to(start("1")).text, "A calibration is under way");
  EXPECT_EQ(desk.reply_to("cancel").status, 409U);
  EXPECT_EQ(made(), 0U);
}

TEST_F(MapDeskTest, EndsWhereNobodyAsksForTheMapWhoeverAsksForCalibrations) {
  ChildJob job(program(kReads), 400ms);
  MapDesk desk(options_, job, request_);
  CalibrationDesk calibrations({"", "c", "", (folder_ / "calibrations").string(), true, "", "{}"}, job, request_);
  desk.reply_to(start("1"));
  for (int i = 0; i < 100; ++i) {
    static_cast<void>(calibrations.state_json());
    std::this_thread::sleep_for(10ms);
  }
  expect_part(until(desk, "No page has asked"), R"("phase":"failed")");
  for (int i = 0; i < 200 && made() > 0; ++i) std::this_thread::sleep_for(5ms);
  EXPECT_EQ(made(), 0U) << "of a map that failed nothing is kept";
}

TEST_F(MapDeskTest, HandsOverTheOneThatIsToBeUsed) {
  const std::string socket = (folder_ / "socket").string();
  ApplyRequest request(socket);
  ChildJob job(program(kFinishes));
  MapDesk desk(options_, job, request);
  fs::create_directories(folder_ / "maps/20261123-121415");
  std::ofstream(folder_ / "maps/20261123-121415/map.toml") << "[[landmarks]]";
  EXPECT_EQ(desk.reply_to("use 20261123-121415").status, 403U) << "nobody listens";
  test::Applier applier(socket, "up: it runs\n");
  applier.serve(20);
  EXPECT_EQ(desk.reply_to("use 20261123-121415").status, 202U);
  EXPECT_EQ(applier.heard(), "map 13\n[[landmarks]]");
  while (request.json().find("running") != std::string::npos) std::this_thread::sleep_for(2ms);
}

TEST_F(MapDeskTest, DoesNothingWhereItMayNot) {
  options_.why_not = "no place";
  ChildJob job(program(kFinishes));
  MapDesk desk(options_, job, request_);
  for (const std::string& text : {start("1"), std::string("cancel"), std::string("use 20261123-121415")})
    EXPECT_EQ(desk.reply_to(text).status, 403U) << text;
  EXPECT_EQ(words(), "");
  Config config;
  expect_part(map_desk_options(config, "c", true).why_not, "set `recordings` of [web]");
  config.web.recordings = "/var/lib/ninedot-web";
  expect_part(map_desk_options(config, "c", false).why_not, "set `token_file` of [web]");
  EXPECT_EQ(map_desk_options(config, "c", true).why_not, "");
}

}  // namespace
}  // namespace ninedot
