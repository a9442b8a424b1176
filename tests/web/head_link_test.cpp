#include "programs/web/head_link.h"

#include <gtest/gtest.h>

#include <cerrno>

#include "drivers/modbus/server.h"
#include "tests/proto/known_report.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

/// A service with a head that stands still, as far as its registers tell.
class WebHeadLink : public testing::Test {
 protected:
  WebHeadLink() {
    options_.allow_writes = true;
    options_.supported_commands = 0b1110;
    options_.tcp.emplace().port = 0;
    tell(AimState::kTrack);
  }
  void tell(AimState state) {
    report_.has_head = true;
    report_.inhibited = report_.servo_fault = false;
    report_.pan_deg = 12.34;
    report_.tilt_deg = -5.5;
    report_.head_state = state;
    reports_.publish(report_);
  }
  HeadLink& link() {
    if (!server_) server_.emplace(reports_, options_);
    if (!link_) link_.emplace("127.0.0.1", server_->tcp_port());
    return *link_;
  }
  /// As a controller writes, whole or nothing.
  void write(std::uint16_t first, std::vector<std::uint16_t> values) {
    auto client = ModbusTcpClient::connect("127.0.0.1", server_->tcp_port(), 2s);
    ASSERT_TRUE(client && client->write_registers(first, values));
  }

  WireReport report_ = test::known_report(mono_now());
  test::WireBox reports_;
  ModbusOptions options_;
  std::optional<ModbusServer> server_;
  std::optional<HeadLink> link_;
};

TEST_F(WebHeadLink, SeesWhatTheServiceSaysOfItsHead) {
  auto view = link().look();
  ASSERT_TRUE(view) << view.error().text;
  EXPECT_EQ(view->at, (HeadDegrees{12.34, -5.5}));
  EXPECT_TRUE(view->has_head && view->writes_enabled && view->follows_by_state);
  EXPECT_FALSE(view->inhibited || view->failed || HeadLink::is_of_page(*view) || link().is_overruled(*view));
  EXPECT_EQ(view->command, Command::kNone);
  tell(AimState::kHold);
  view = link().look();
  EXPECT_FALSE(view->follows_by_state);
}

TEST_F(WebHeadLink, SendsTheHeadToAPlaceAndLetsItFollow) {
  ASSERT_TRUE(link().look());
  EXPECT_FALSE(link().has_told({1, 2}));
  ASSERT_TRUE(link().point({-20.5, 3.25}));
  auto command = server_->try_take_command();
  ASSERT_TRUE(command);
  EXPECT_EQ(command->command, Command::kPoint);
  EXPECT_NEAR(command->pan_rad * 180 / std::numbers::pi, -20.5, 1e-9);
  EXPECT_NEAR(command->tilt_rad * 180 / std::numbers::pi, 3.25, 1e-9);
  EXPECT_TRUE(link().has_told({-20.501, 3.25})) << "the same to a hundredth of a degree";
  EXPECT_FALSE(link().has_told({-20.51, 3.25}));
  const auto view = link().look();
  EXPECT_TRUE(HeadLink::is_of_page(*view));
  EXPECT_FALSE(link().is_overruled(*view));
  ASSERT_TRUE(link().point({-20, 3.25}));
  EXPECT_TRUE(server_->try_take_command()) << "each one is carried out";
  ASSERT_TRUE(link().follow());
  command = server_->try_take_command();
  ASSERT_TRUE(command);
  EXPECT_EQ(command->command, Command::kFollow);
}

TEST_F(WebHeadLink, LeavesTheNextNumberToAControllerThatCounts) {
  for (const int last : {0, 5, 0x9D09, 0xA9CF, 0xD099, 0xFFFF}) {
    ASSERT_TRUE(link().look());
    write(reg::kCommand, {1, static_cast<std::uint16_t>(last)});
    ASSERT_TRUE(link().look());
    for (int i = 0; i < 5; ++i) {
      ASSERT_TRUE(link().point({0.1 * i, 0}));
      const auto view = link().look();
      ASSERT_TRUE(view);
      EXPECT_NE(view->sequence, static_cast<std::uint16_t>(last + 1));
      EXPECT_FALSE(link().is_overruled(*view));
    }
    server_->try_take_command();
    write(reg::kCommand, {1, static_cast<std::uint16_t>(last + 1)});
    EXPECT_TRUE(server_->try_take_command()) << last;
  }
}

TEST_F(WebHeadLink, SeesThatAnotherOneCommands) {
  const auto is_overruled_after = [&](std::uint16_t first, std::vector<std::uint16_t> values) {
    EXPECT_TRUE(link().look());
    EXPECT_TRUE(link().point({10, 0}));
    write(first, std::move(values));
    return link().is_overruled(*link().look());
  };
  EXPECT_TRUE(is_overruled_after(reg::kCommand, {1, 17}));
  EXPECT_TRUE(is_overruled_after(reg::kCommand, {2, 18}));
  EXPECT_TRUE(is_overruled_after(reg::kCommand, {3})) << "about to park it";
  EXPECT_TRUE(is_overruled_after(reg::kPanSetPoint, {4500})) << "about to send it elsewhere";
  EXPECT_FALSE(is_overruled_after(reg::kHold, {1}));
  link().close();
  EXPECT_FALSE(link().is_overruled(*link().look())) << "as it was found";
  write(reg::kCommand, {2, 19});
  EXPECT_TRUE(link().is_overruled(*link().look())) << "before the page said anything";
  link().close();
  const auto view = link().look();
  EXPECT_FALSE(link().is_overruled(*view)) << "what was told is forgotten with the connection";
}

TEST_F(WebHeadLink, NeverOverwritesWhatItHasNotSeen) {
  const auto is_refused_after = [&](std::uint16_t first, std::vector<std::uint16_t> values, auto&& command) {
    EXPECT_TRUE(link().look());
    EXPECT_TRUE(link().point({10, 0}));
    (void)server_->try_take_command();
    EXPECT_TRUE(link().look());
    write(first, values);
    const auto theirs = server_->try_take_command();
    EXPECT_EQ(command().error().os_errno, EBUSY);
    EXPECT_FALSE(server_->try_take_command()) << "the controller's has the last word";
    const auto view = link().look();
    EXPECT_TRUE(view && link().is_overruled(*view));
    link().close();
    return theirs;
  };
  const auto point = [&] { return link().point({11, 0}); };
  const auto follow = [&] { return link().follow(); };
  EXPECT_EQ(is_refused_after(reg::kCommand, {2, 17}, point)->sequence, 17);
  EXPECT_EQ(is_refused_after(reg::kCommand, {3, 18}, follow)->sequence, 18);
  EXPECT_FALSE(is_refused_after(reg::kPanSetPoint, {4500, 300}, point));
  // Whose command comes now, for the set-points that it wrote.
  write(reg::kCommand, {2, 19});
  const auto theirs = server_->try_take_command();
  ASSERT_TRUE(theirs);
  EXPECT_NEAR(theirs->pan_rad * 180 / std::numbers::pi, 45, 1e-9);
  EXPECT_NEAR(theirs->tilt_rad * 180 / std::numbers::pi, 3, 1e-9);
}

TEST_F(WebHeadLink, SaysWhatFails) {
  options_.allow_writes = false;
  const auto view = link().look();
  ASSERT_TRUE(view);
  EXPECT_FALSE(view->writes_enabled);
  EXPECT_NE(std::string(link().point({}).error().text).find("refused"), std::string::npos);
  EXPECT_FALSE(link().follow()) << "not connected";
  server_.reset();
  EXPECT_FALSE(link().look());
}

}  // namespace
}  // namespace ninedot
