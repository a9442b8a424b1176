#include "programs/web/jogger.h"

#include <gtest/gtest.h>

#include <atomic>
#include <optional>
#include <vector>

#include "drivers/modbus/client.h"
#include "drivers/modbus/server.h"
#include "tests/modbus/relay.h"
#include "tests/proto/known_report.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

constexpr const char* kOurs = "ours0000";
constexpr const char* kOther = "other000";

/// A service whose head stands where its registers say; what it is commanded is counted.
class WebJogger : public testing::Test {
 protected:
  WebJogger() {
    ModbusOptions options;
    options.allow_writes = true;
    options.supported_commands = 0b1110;
    options.tcp.emplace().port = 0;
    tell(AimState::kTrack);
    server_.emplace(reports_, options);
    options_.driver = "simulated";
    options_.host = "127.0.0.1";
    options_.port = server_->tcp_port();
    options_.pan = options_.tilt = {-60, 60, 30};
  }
  void tell(AimState state, bool inhibited = false) {
    report_.has_head = true;
    report_.servo_fault = false;
    report_.inhibited = inhibited;
    report_.pan_deg = 10;
    report_.tilt_deg = -5;
    report_.head_state = state;
    reports_.publish(report_);
  }
  /// Whatever another thread brings about.
  template <typename Condition>
  static bool soon(Condition condition) {
    const MonoTime deadline = mono_now() + 5s;
    while (!condition()) {
      if (mono_now() > deadline) return false;
      std::this_thread::sleep_for(1ms);
    }
    return true;
  }
  bool says(const std::string& text, const char* viewer = kOurs) {
    return jogger_->state_json(viewer).find(text) != std::string::npos;
  }
  bool becomes(const std::string& text, const char* viewer = kOurs) {
    return soon([&] { return says(text, viewer); });
  }
  void start() {
    jogger_.emplace(options_);
    ASSERT_TRUE(becomes("\"phase\":\"free\""));
  }
  unsigned post(const std::string& text) { return jogger_->reply_to(text, "10.0.0.7").status; }
  void take() {
    ASSERT_EQ(post(std::string("take ") + kOurs), 200U);
    ASSERT_TRUE(becomes("\"phase\":\"held\",\"mine\":true"));
    ASSERT_TRUE(soon([&] { return newest() == Command::kPoint; })) << "it stands";
    tell(AimState::kHold);
  }
  /// A keep-alive of now.
  unsigned jog(double pan_deg_s) {
    const auto now_ms = std::chrono::floor<std::chrono::milliseconds>(mono_now().time_since_epoch()).count();
    return post("jog " + std::string(kOurs) + " " + std::to_string(++number_) + " " + std::to_string(now_ms) + " " +
                std::to_string(pan_deg_s) + " 0");
  }
  /// The newest command since the last call.
  Command newest() {
    Command command = Command::kNone;
    while (const auto next = server_->try_take_command()) command = next->command, pan_rad_ = next->pan_rad;
    return command;
  }
  void write(std::uint16_t first, const std::vector<std::uint16_t>& values) {
    auto client = ModbusTcpClient::connect("127.0.0.1", server_->tcp_port(), 2s);
    ASSERT_TRUE(client && client->write_registers(first, values));
  }

  WireReport report_ = test::known_report(mono_now());
  test::WireBox reports_;
  std::optional<ModbusServer> server_;
  JoggerOptions options_;
  std::optional<Jogger> jogger_;
  std::uint32_t number_ = 0;
  double pan_rad_ = 0;
};

TEST_F(WebJogger, TakesTurnsAndGivesBackAHeadThatFollows) {
  start();
  EXPECT_EQ(newest(), Command::kNone) << "nothing was left to clear up";
  take();
  EXPECT_NEAR(pan_rad_, 10 * std::numbers::pi / 180, 1e-9) << "where it is";
  EXPECT_TRUE(soon([&] { return jog(20) == 200U && newest() == Command::kPoint; }));
  EXPECT_GT(pan_rad_, 10 * std::numbers::pi / 180);
  EXPECT_EQ(post("take other000"), 409U);
  EXPECT_TRUE(says("\"mine\":false,\"holder\":\"10.0.0.7\"", kOther));
  EXPECT_EQ(post(std::string("give ") + kOurs), 200U);
  EXPECT_TRUE(soon([&] { return newest() == Command::kFollow; }));
  EXPECT_TRUE(becomes("\"phase\":\"free\""));
  EXPECT_EQ(jog(20), 409U);
}

TEST_F(WebJogger, LeavesAHeadThatDidNotFollowWhereItIs) {
  options_.follows = false;
  tell(AimState::kHold);
  start();
  take();
  post(std::string("give ") + kOurs);
  EXPECT_TRUE(becomes("\"phase\":\"free\""));
  EXPECT_EQ(newest(), Command::kNone);
}

TEST_F(WebJogger, TakesNoHeadThatAControllerCommands) {
  tell(AimState::kHold);
  start();
  for (const Command command : {Command::kPoint, Command::kPark}) {
    const auto code = static_cast<std::uint16_t>(command);
    write(reg::kCommand, {code, static_cast<std::uint16_t>(100 + code)});
    newest();
    EXPECT_EQ(post(std::string("take ") + kOurs), 200U) << "it is found out";
    EXPECT_TRUE(becomes("A controller"));
    EXPECT_TRUE(says("\"phase\":\"free\""));
    EXPECT_EQ(newest(), Command::kNone);
  }
  EXPECT_EQ(post(std::string("follow ") + kOurs), 200U);
  EXPECT_TRUE(soon([&] { return newest() == Command::kFollow; })) << "when somebody says so";
  EXPECT_TRUE(becomes("\"phase\":\"free\""));
  take();
}

TEST_F(WebJogger, StepsBackWhenAControllerCommands) {
  start();
  take();
  write(reg::kCommand, {2, 17});
  EXPECT_TRUE(becomes("A controller commands the head"));
  EXPECT_TRUE(becomes("\"phase\":\"free\""));
  EXPECT_EQ(newest(), Command::kPoint) << "the controller's";
  EXPECT_EQ(jog(20), 409U);
  EXPECT_EQ(newest(), Command::kNone) << "and the last word is its";
}

TEST_F(WebJogger, AHeadWhoseSetPointsAreWrittenWithoutACommandGoesBack) {
  start();
  take();
  write(reg::kPanSetPoint, {4500});
  EXPECT_TRUE(becomes("A controller commands the head"));
  EXPECT_TRUE(soon([&] { return newest() == Command::kFollow; }));
}

// Whatever the page was about to write when the controller's request came.
TEST_F(WebJogger, AControllersCommandIsNeverLost) {
  std::atomic<unsigned> overtaken_at{0};
  std::atomic<bool> writes_all{false};
  std::atomic<std::uint16_t> number{0};
  test::Relay relay(server_->tcp_port(), [&](unsigned first) {
    if (first != overtaken_at) return;
    overtaken_at = 0;
    write(reg::kPanSetPoint, {4500, 300});
    if (writes_all) write(reg::kCommand, {2, ++number});
  });
  options_.port = relay.port();
  start();
  for (const bool whole : {true, false})
    for (const unsigned first : {unsigned{reg::kPanSetPoint}, unsigned{reg::kCommand}}) {
      take();
      writes_all = whole;
      overtaken_at = first;
      ASSERT_TRUE(soon([&] { return jog(25) == 409U; })) << first;
      EXPECT_TRUE(says("A controller commands the head")) << first;
      if (!whole) write(reg::kCommand, {2, ++number});
      ASSERT_TRUE(becomes("\"phase\":\"free\""));
      EXPECT_EQ(newest(), Command::kPoint);
      EXPECT_NEAR(pan_rad_, 45 * std::numbers::pi / 180, 1e-9) << "where the controller sent it, at " << first;
      write(reg::kCommand, {1, static_cast<std::uint16_t>(1000 + number)});
      tell(AimState::kTrack);
    }
  jogger_.reset();
}

TEST_F(WebJogger, AnInhibitedHeadIsSentNowhere) {
  start();
  take();
  tell(AimState::kHold, true);
  for (const MonoTime end = mono_now() + 200ms; mono_now() < end; std::this_thread::sleep_for(10ms)) {
    EXPECT_EQ(jog(20), 200U);
    EXPECT_EQ(newest(), Command::kNone);
  }
}

TEST_F(WebJogger, GivesBackWhenItEnds) {
  start();
  take();
  jogger_.reset();
  EXPECT_EQ(newest(), Command::kFollow);
}

TEST_F(WebJogger, ClearsUpAfterAProcessThatWasKilled) {
  HeadLink killed("127.0.0.1", server_->tcp_port());
  ASSERT_TRUE(killed.look() && killed.point({10, 10}));
  EXPECT_EQ(newest(), Command::kPoint);
  start();
  EXPECT_EQ(newest(), Command::kFollow);
}

TEST_F(WebJogger, LeavesAlonePlacesToWhichOthersSentTheHead) {
  write(reg::kCommand, {2, 17});
  newest();
  start();
  EXPECT_EQ(newest(), Command::kNone);
}

TEST_F(WebJogger, IsToldThatTheServiceIsGone) {
  start();
  take();
  server_.reset();
  EXPECT_TRUE(becomes("The service does not answer"));
  EXPECT_EQ(jog(20), 409U);
}

TEST_F(WebJogger, SaysWhatIsMissing) {
  Config config;
  EXPECT_NE(jogger_options(config, true).why_not.find("No pan/tilt head"), std::string::npos);
  config.pan_tilt.driver = "simulated";
  EXPECT_NE(jogger_options(config, true).why_not.find("[modbus.tcp]"), std::string::npos);
  config.modbus_tcp.enabled = true;
  EXPECT_NE(jogger_options(config, true).why_not.find("allow_writes"), std::string::npos);
  config.modbus.allow_writes = true;
  EXPECT_NE(jogger_options(config, false).why_not.find("token_file"), std::string::npos);
  EXPECT_EQ(jogger_options(config, true).why_not, "");
  options_.why_not = "\"so\"";
  jogger_.emplace(options_);
  EXPECT_TRUE(says(R"("why_not":"\"so\"")"));
  for (const char* text : {"take ours0000", "follow ours0000", "jog ours0000 1 0 1 1"}) EXPECT_EQ(post(text), 409U);
  EXPECT_EQ(post("park ours0000"), 400U);
}

TEST_F(WebJogger, ReachesTheServiceWhereItListens) {
  Config config;
  for (const auto& [listen, host] : std::vector<std::pair<std::string, std::string>>{
           {"0.0.0.0", "127.0.0.1"}, {"::", "::1"}, {"127.0.0.1", "127.0.0.1"}, {"192.168.1.5", "192.168.1.5"}}) {
    config.modbus_tcp.listen = listen;
    EXPECT_EQ(jogger_options(config, true).host, host);
  }
  config.pan_tilt.pan.slew_deg_per_s = 12;
  EXPECT_EQ(jogger_options(config, true).pan.fastest_deg_s, 12) << "no faster than the head";
  EXPECT_EQ(jogger_options(config, true).tilt.fastest_deg_s, JogPath::kFastest_deg_s);
}

}  // namespace
}  // namespace ninedot
