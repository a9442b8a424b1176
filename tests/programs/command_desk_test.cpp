#include "programs/service/command_desk.h"

#include <gtest/gtest.h>

namespace ninedot {
namespace {

ClientCommand point(std::uint16_t sequence) { return {Command::kPoint, sequence, 0.5, 0.25, false}; }
ReportHead head(std::uint32_t order, OrderProgress progress) {
  ReportHead head;
  head.order = order;
  head.progress = progress;
  return head;
}

TEST(CommandDesk, ACommandRunsUntilTheReportSaysThatItsOwnOrderHasEnded) {
  CommandDesk desk;
  const AimOrder order = desk.accept(point(77));
  EXPECT_FALSE(order.follow);
  EXPECT_EQ(order.set_point.pan_rad, 0.5);
  EXPECT_FALSE(desk.end_by(head(0, OrderProgress::kNone))) << "not even seen yet";
  EXPECT_FALSE(desk.end_by(head(order.number, OrderProgress::kRunning)));
  const auto ended = desk.end_by(head(order.number, OrderProgress::kDone));
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->sequence, 77);
  EXPECT_TRUE(ended->succeeded);
  EXPECT_FALSE(desk.end_by(head(order.number, OrderProgress::kDone))) << "once";
}

TEST(CommandDesk, ACommandToParkIsAnOrderToPark) {
  CommandDesk desk;
  EXPECT_TRUE(desk.accept({Command::kPark, 4, 0.5, 0.25, false}).park);
  EXPECT_FALSE(desk.accept(point(5)).park);
  EXPECT_FALSE(desk.accept({Command::kFollow, 6, 0, 0, false}).park);
}

TEST(CommandDesk, WhatAnOlderOrderHasDoneIsNotTheNewerCommandsResult) {
  CommandDesk desk;
  const AimOrder older = desk.accept(point(1)), newer = desk.accept(point(2));
  EXPECT_FALSE(desk.end_by(head(older.number, OrderProgress::kDone)));
  const auto ended = desk.end_by(head(newer.number, OrderProgress::kFailed));
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->sequence, 2);
  EXPECT_FALSE(ended->succeeded);
}

TEST(CommandDesk, AWatchdogThatTakesTheHeadAwayMakesTheCommandFail) {
  CommandDesk desk;
  ClientCommand watchdog;
  watchdog.command = Command::kFollow;
  watchdog.from_watchdog = true;
  EXPECT_FALSE(desk.end_for_watchdog(watchdog)) << "nothing is under way";
  desk.accept(point(9));
  EXPECT_FALSE(desk.end_for_watchdog(point(10))) << "a client's command takes its place without a result";
  const auto ended = desk.end_for_watchdog(watchdog);
  ASSERT_TRUE(ended);
  EXPECT_EQ(ended->sequence, 9);
  EXPECT_FALSE(ended->succeeded);
  const AimOrder order = desk.accept(watchdog);
  EXPECT_TRUE(order.follow);
  EXPECT_FALSE(desk.end_by(head(order.number, OrderProgress::kDone))) << "nobody waits for it";
}

}  // namespace
}  // namespace ninedot
