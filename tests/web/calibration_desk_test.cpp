// The wizard as the page's process has it: a child that says lines, and everything that can come of one.
#include "programs/web/calibration_desk.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <string_view>
#include <thread>
#include <utility>

#include "tests/web/applier.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

/// With a job of its own.
struct DeskAndJob {
  DeskAndJob(CalibrationDeskOptions options, const std::string& program, ApplyRequest& request,
             std::chrono::nanoseconds unheard = std::chrono::minutes(1))
      : job(program, unheard), desk(std::move(options), job, request) {}
  DeskReply reply_to(std::string_view text) { return desk.reply_to(text); }
  std::string state_json() const { return desk.state_json(); }
  std::string file_of(std::string_view path) const { return desk.file_of(path); }

  ChildJob job;
  CalibrationDesk desk;
};

class CalibrationDeskTest : public testing::Test {
 protected:
  CalibrationDeskTest() {
    std::string pattern = (fs::temp_directory_path() / "ninedot-test-XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr) std::abort();
    folder_ = pattern;
  }
  ~CalibrationDeskTest() override { fs::remove_all(folder_); }

  /// In the place of `ninedot`: a shell script, whose own number is in the file `pid`. \param work  what it does
  CalibrationDeskOptions options(const std::string& work) {
    const fs::path program = folder_ / "ninedot";
    std::ofstream(program) << "#!/bin/bash\necho $$ > " << folder_.string() << "/pid.new; mv " << folder_.string()
                           << "/pid.new " << folder_.string() << "/pid\necho \"$*\" > " << folder_.string()
                           << "/words\n"
                           << work << "\n";
    fs::permissions(program, fs::perms::owner_all);
    return {"", "/etc/ninedot/ninedot.toml", "camera.yaml", (folder_ / "made").string(), true, "", R"({"pan":1})"};
  }
  std::string program() const { return (folder_ / "ninedot").string(); }

  static std::string until(DeskAndJob& desk, const std::string& words) {
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
  std::string text_of(const char* file) const {
    std::ifstream stream(folder_ / file);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  /// The child is gone, and nobody waits for it any more.
  bool is_gone() const {
    const int pid = std::stoi(text_of("pid"));
    for (int i = 0; i < 400 && ::kill(pid, 0) == 0; ++i) std::this_thread::sleep_for(10ms);
    return ::kill(pid, 0) != 0;
  }
  std::size_t made() const {
    std::size_t count = 0;
    std::error_code none;
    for (fs::directory_iterator at(folder_ / "made", none), end; at != end; ++at) ++count;
    return count;
  }

  fs::path folder_;
  ApplyRequest request_{"/nonexistent/socket"};
};

constexpr const char* kGathers = R"(echo '{"state":"gathering","views":3}')";
constexpr const char* kFinishes = R"(echo '{"state":"done","file":"x"}')";

TEST_F(CalibrationDeskTest, SaysWhatTheChildSaysAndThatItIsDone) {
  DeskAndJob desk(options(std::string(kGathers) + "\nsleep 0.3\n" + kFinishes), program(), request_);
  expect_part(desk.state_json(), R"("phase":"idle","number":0,"name":"","why":"","news":null)");
  const DeskReply reply = desk.reply_to("start camera");
  EXPECT_EQ(reply.status, 200U) << reply.text;
  expect_part(reply.text, R"("phase":"running","number":1)");
  expect_part(until(desk, "gathering"), R"("phase":"running","number":1)");
  expect_part(until(desk, "\"done\","), R"("news":{"state":"done","file":"x"})");
  expect_part(text_of("words"),
              "calibrate camera --tap --config /etc/ninedot/ninedot.toml --out " + (folder_ / "made/").string());
  expect_part(text_of("words"), "/camera.yaml --progress json\n");
  EXPECT_EQ(made(), 1U);
}

TEST_F(CalibrationDeskTest, HasOneChildAtATime) {
  DeskAndJob desk(options(std::string(kGathers) + "\nexec sleep 60"), program(), request_);
  EXPECT_EQ(desk.reply_to("start camera").status, 200U);
  EXPECT_EQ(desk.reply_to("start camera").status, 409U);
  until(desk, "gathering");
  EXPECT_EQ(desk.reply_to("start camera").status, 409U);
  EXPECT_EQ(made(), 1U);
}

TEST_F(CalibrationDeskTest, CancelsAndKeepsNothing) {
  DeskAndJob desk(options(std::string(kGathers) + "\nexec sleep 60"), program(), request_);
  EXPECT_EQ(desk.reply_to("cancel").status, 409U) << "nothing is under way";
  EXPECT_EQ(desk.reply_to("finish").status, 409U);
  desk.reply_to("start camera");
  until(desk, "gathering");
  EXPECT_EQ(desk.reply_to("cancel").status, 200U);
  EXPECT_EQ(desk.reply_to("finish").status, 409U) << "it is being cancelled";
  expect_part(until(desk, R"("news":null)"), R"("phase":"cancelled")");
  EXPECT_TRUE(is_gone());
  EXPECT_EQ(made(), 0U);
}

TEST_F(CalibrationDeskTest, FinishesEarlyAsCtrlCDoes) {
  DeskAndJob desk(options(std::string("trap '") + R"(echo "{\"state\":\"done\"}"; exit 0)" + "' INT\n" + kGathers +
                          "\nwhile :; do sleep 0.05; done"),
                  program(), request_);
  desk.reply_to("start camera");
  until(desk, "gathering");
  EXPECT_EQ(desk.reply_to("finish").status, 200U);
  expect_part(until(desk, R"("phase":"done")"), R"("phase":"done")");
}

TEST_F(CalibrationDeskTest, EndsTheChildThatNoPageAsksFor) {
  DeskAndJob desk(options(std::string(kGathers) + "\nexec sleep 60"), program(), request_, 300ms);
  desk.reply_to("start camera");
  until(desk, "gathering");
  std::this_thread::sleep_for(1s);
  EXPECT_TRUE(is_gone());
  expect_part(desk.state_json(), R"("phase":"failed")");
  expect_part(desk.state_json(), "No page has asked for a minute");
  EXPECT_EQ(made(), 1U) << "what it has seen is kept";
}

TEST_F(CalibrationDeskTest, TakesTheChildAlongWhenItEnds) {
  const auto begun = std::chrono::steady_clock::now();
  {
    DeskAndJob desk(options(std::string(kGathers) + "\nexec sleep 60"), program(), request_);
    desk.reply_to("start camera");
    until(desk, "gathering");
  }
  EXPECT_TRUE(is_gone());
  EXPECT_LT(std::chrono::steady_clock::now() - begun, 40s) << "it slept for as long as it liked";
}

TEST_F(CalibrationDeskTest, SaysWhyNothingCameOfIt) {
  DeskAndJob refused(options(R"(echo '{"state":"failed","why":"no tap"}'; exit 1)"), program(), request_);
  refused.reply_to("start camera");
  expect_part(until(refused, R"("phase":"failed")"), R"("why":"","news":{"state":"failed","why":"no tap"})");
  DeskAndJob silent(options("exit 3"), program(), request_);
  EXPECT_EQ(silent.reply_to("start camera").status, 200U) << "names are seconds, and that of the one before is kept";
  expect_part(until(silent, R"("phase":"failed")"), "ended with status 3");
  DeskAndJob killed(options("kill -9 $$"), program(), request_);
  killed.reply_to("start camera");
  expect_part(until(killed, R"("phase":"failed")"), "by signal 9");
  const DeskReply reply = DeskAndJob(options(""), (folder_ / "none").string(), request_).reply_to("start camera");
  EXPECT_EQ(reply.status, 500U);
  expect_part(reply.text, "can't be started");
  fs::remove_all(folder_ / "made");
  std::ofstream(folder_ / "made") << "no folder";
  const DeskReply nowhere = DeskAndJob(options(""), program(), request_).reply_to("start camera");
  EXPECT_EQ(nowhere.status, 409U);
  expect_part(nowhere.text, "can't be made: Not a directory");
}

TEST_F(CalibrationDeskTest, IsNotImpressedByWhatIsNoLineOfNews) {
  DeskAndJob desk(options(std::string(kGathers) +
                          "\necho nonsense\necho '{\"state\":\"cut'\nhead -c 300000 /dev/zero | tr '\\0' x\necho "
                          "'}'\nprintf '{\"state\":\"done\"'\n"),
                  program(), request_);
  desk.reply_to("start camera");
  expect_part(until(desk, R"("phase":"failed")"), R"("news":{"state":"gathering","views":3})");
}

TEST_F(CalibrationDeskTest, KeepsTheNewestThree) {
  const CalibrationDeskOptions how = options(kFinishes);
  for (const char* name : {"20200101-000000", "20200101-000001", "20200101-000002", "20200101-000003"})
    fs::create_directories(folder_ / "made" / name / "camera-views");
  fs::create_directories(folder_ / "made/somebody-elses");
  DeskAndJob desk(how, program(), request_);
  desk.reply_to("start camera");
  until(desk, R"("phase":"done")");
  EXPECT_FALSE(fs::exists(folder_ / "made/20200101-000001"));
  EXPECT_TRUE(fs::exists(folder_ / "made/20200101-000002"));
  EXPECT_TRUE(fs::exists(folder_ / "made/20200101-000003"));
  EXPECT_TRUE(fs::exists(folder_ / "made/somebody-elses"));
}

TEST_F(CalibrationDeskTest, KnowsItsOwnFilesAlone) {
  const DeskAndJob desk(options(""), program(), request_);
  EXPECT_EQ(desk.file_of("20261123-121415/camera.yaml"), (folder_ / "made/20261123-121415/camera.yaml").string());
  EXPECT_EQ(desk.file_of("20261123-121415/camera.svg"), (folder_ / "made/20261123-121415/camera.svg").string());
  for (const char* path :
       {"", "/", "20261123-121415", "20261123-121415/", "20261123-121415/camera.yaml/", "../camera.yaml",
        "20261123-121415/../camera.yaml", "20261123-121415/..", "20261123-121415/camera-views/frames.csv",
        "20261123-121415//camera.yaml", "20261123-12141x/camera.yaml", "20261123-121415-asked/camera.yaml",
        "20261123-121415%2fcamera.yaml", "20261123-121415/camera.svg%00", "/20261123-121415/camera.svg"})
    EXPECT_EQ(desk.file_of(path), "") << path;
}

TEST_F(CalibrationDeskTest, HandsOverTheOneThatIsToBeUsed) {
  const std::string socket = (folder_ / "socket").string();
  ApplyRequest request(socket);
  CalibrationDeskOptions how = options(kFinishes);
  DeskAndJob desk(how, program(), request);
  fs::create_directories(folder_ / "made/20261123-121415");
  std::ofstream(folder_ / "made/20261123-121415/camera.yaml") << "lens";
  EXPECT_EQ(desk.reply_to("use 20261123-121415").status, 403U) << "nobody listens";
  expect_part(desk.state_json(), "switched off");
  test::Applier applier(socket, "up: it runs\n");
  expect_part(desk.state_json(), R"("use":"",)");
  for (const char* none : {"use ", "use 20261123-121415/", "use ../20261123-121415", "use 20261123-121415 "})
    EXPECT_EQ(desk.reply_to(none).status, 400U) << none;
  EXPECT_EQ(desk.reply_to("use 20261123-000000").status, 409U) << "is not there";
  applier.serve(18);
  EXPECT_EQ(desk.reply_to("use 20261123-121415").status, 202U);
  EXPECT_EQ(applier.heard(), "calibration 4\nlens");
  while (request.json().find("running") != std::string::npos) std::this_thread::sleep_for(2ms);
  expect_part(request.json(), R"("state":"up")");
  how.has_token = false;
  EXPECT_EQ(DeskAndJob(how, program(), request).reply_to("use 20261123-121415").status, 403U);
}

TEST_F(CalibrationDeskTest, CalibratesTheHeadAsWell) {
  const std::string socket = (folder_ / "socket").string();
  ApplyRequest request(socket);
  CalibrationDeskOptions how = options(R"(echo "[body]" > "${@:7:1}"; )" + std::string(kFinishes));
  DeskAndJob desk(how, program(), request);
  expect_part(desk.state_json(), R"("head":{"why_not":"","limits":{"pan":1}},"of":"camera",)");
  EXPECT_EQ(desk.reply_to("start pan-tilt").status, 200U);
  const std::string done = until(desk, R"("phase":"done")");
  expect_part(done, R"("of":"pan-tilt")");
  const std::string name = fs::directory_iterator(folder_ / "made")->path().filename();
  EXPECT_EQ(text_of("words"), "calibrate pan-tilt --tap --config /etc/ninedot/ninedot.toml --out " +
                                  desk.file_of(name + "/head.toml") + " --progress json\n");
  test::Applier applier(socket, "up: it runs\n");
  applier.serve(14);
  ASSERT_EQ(desk.reply_to("use " + name).status, 202U);
  EXPECT_EQ(applier.heard(), "head 7\n[body]\n");
  how.no_head = "no head here";
  DeskAndJob headless(how, program(), request);
  expect_part(headless.state_json(), R"("head":{"why_not":"no head here")");
  EXPECT_EQ(headless.reply_to("start pan-tilt").status, 403U);
  EXPECT_EQ(made(), 1U);
}

TEST_F(CalibrationDeskTest, UnderstandsItsWordsAndNothingWhereItMayNot) {
  CalibrationDeskOptions how = options(kFinishes);
  DeskAndJob desk(how, program(), request_);
  for (const char* text :
       {"", "start", "start camera ", "start pan-tilt --stops 25x25", "start camera --out /etc/passwd", "cancel\n"})
    EXPECT_EQ(desk.reply_to(text).status, 400U) << text;
  how.why_not = "no place";
  DeskAndJob closed(how, program(), request_);
  EXPECT_EQ(closed.reply_to("start camera").status, 403U);
  expect_part(closed.state_json(), R"({"why_not":"no place",)");
  EXPECT_EQ(made(), 0U);
  Config config;
  expect_part(calibration_desk_options(config, "c", true).why_not, "set `recordings` of [web]");
  config.web.recordings = "/var/lib/ninedot-web";
  expect_part(calibration_desk_options(config, "c", false).why_not, "set `token_file` of [web]");
  EXPECT_EQ(calibration_desk_options(config, "c", true).why_not, "");
  expect_part(calibration_desk_options(config, "c", true).no_head, "set `driver` of [pan_tilt]");
  config.pan_tilt.driver = "simulated", config.modbus_tcp.enabled = config.modbus.allow_writes = true;
  config.pan_tilt.pan.min_deg = -40.5;
  EXPECT_EQ(calibration_desk_options(config, "c", true).no_head, "");
  expect_part(calibration_desk_options(config, "c", true).limits, R"({"pan":{"min":-40.5,"max":)");
}

}  // namespace
}  // namespace ninedot
