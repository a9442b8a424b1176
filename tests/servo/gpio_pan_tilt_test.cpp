#include "drivers/servo/gpio_pan_tilt.h"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <mutex>
#include <thread>
#include <vector>

namespace ninedot {
namespace {

using namespace std::chrono_literals;

constexpr double kDeg = 3.14159265358979 / 180;

struct Edge {
  MonoTime at;
  bool active;
};

/// What an oscilloscope on the line would see.
struct Scope {
  std::vector<Edge> edges() const {
    const std::lock_guard lock(mutex);
    return seen;
  }
  mutable std::mutex mutex;
  std::vector<Edge> seen;
  std::atomic<int> error{0};
  std::atomic<std::chrono::milliseconds> late_to_fall{0ms};
};

class ScopedLine final : public DigitalOutput {
 public:
  explicit ScopedLine(Scope& scope) : scope_(scope) {}
  Result<void> set(bool active) noexcept override {
    if (!active) std::this_thread::sleep_for(scope_.late_to_fall.load());
    const std::lock_guard lock(scope_.mutex);
    scope_.seen.push_back({mono_now(), active});
    if (scope_.error != 0) return fail(Errc::kIo, "no such line", scope_.error);
    return {};
  }

 private:
  Scope& scope_;
};

ServoAxes axes() {
  constexpr std::array kPoints{AxisPoint{-45 * kDeg, 1000}, AxisPoint{45 * kDeg, 2000}};
  return {ServoAxis(kPoints, 1000, 2000), ServoAxis(kPoints, 1000, 2000)};
}

struct Head {
  explicit Head(const HeadAngles& neutral)
      : unit(std::make_unique<GpioPanTilt>(std::make_unique<ScopedLine>(pan), std::make_unique<ScopedLine>(tilt),
                                           GpioPanTiltOptions{5ms, 0}, axes(), neutral)) {}
  Scope pan, tilt;
  std::unique_ptr<GpioPanTilt> unit;
};

/// Widths of the pulses that were complete.
std::vector<std::chrono::nanoseconds> widths(const Scope& scope) {
  std::vector<std::chrono::nanoseconds> widths;
  const std::vector<Edge> edges = scope.edges();
  for (std::size_t i = 1; i < edges.size(); i += 2) widths.push_back(edges[i].at - edges[i - 1].at);
  return widths;
}

std::chrono::nanoseconds shortest(const Scope& scope) { return std::ranges::min(widths(scope)); }

void wait_for_pulses(const Scope& scope, std::size_t count) {
  const MonoTime until = mono_now() + 20s;
  while (scope.edges().size() < 2 * count && mono_now() < until) std::this_thread::sleep_for(5ms);
  ASSERT_GE(scope.edges().size(), 2 * count);
}

TEST(GpioPanTilt, MakesPulsesOfTheAxesOwnWidthsAndNeverShorterOnes) {
  Head head({9 * kDeg, -18 * kDeg});
  wait_for_pulses(head.tilt, 20);
  // A busy machine makes single pulses longer; none may be shorter than told, and most are not much longer.
  EXPECT_GE(shortest(head.pan), 1595us);
  EXPECT_GE(shortest(head.tilt), 1295us);
  EXPECT_LT(shortest(head.pan), 1900us);
  EXPECT_LT(shortest(head.tilt), 1600us);
}

TEST(GpioPanTilt, FollowsANewCommandFromTheNextPulseOn) {
  Head head({});
  wait_for_pulses(head.pan, 3);
  head.unit->move_to({45 * kDeg, 0});
  EXPECT_NEAR(head.unit->state().angles.pan_rad, 45 * kDeg, 1e-6);
  const std::size_t before = widths(head.pan).size() + 1;
  wait_for_pulses(head.pan, before + 5);
  const auto all = widths(head.pan);
  for (std::size_t i = before; i < all.size(); ++i) EXPECT_GE(all[i], 1995us);
}

TEST(GpioPanTilt, MeasuresHowFarItsPulsesAreOff) {
  Head head({});
  wait_for_pulses(head.tilt, 20);
  const HeadState state = head.unit->state();
  EXPECT_GT(state.pulse_error_max, 0ns) << "a thread that wakes up to the nanosecond does not exist";
  EXPECT_LE(state.pulse_error_p99, state.pulse_error_max);
}

TEST(GpioPanTilt, LeavesBothLinesLow) {
  Head head({});
  wait_for_pulses(head.pan, 2);
  head.unit.reset();
  EXPECT_FALSE(head.pan.edges().back().active);
  EXPECT_FALSE(head.tilt.edges().back().active);
}

TEST(GpioPanTilt, ReportsALineThatCanNotBeDriven) {
  Head head({});
  wait_for_pulses(head.pan, 1);
  EXPECT_FALSE(head.unit->state().failed);
  head.tilt.error = 5;
  const std::size_t now = widths(head.tilt).size();
  wait_for_pulses(head.tilt, now + 3);
  EXPECT_TRUE(head.unit->state().failed) << "though the other line is well";
}

TEST(PulseErrors, TellTheErrorBelowWhich99PercentLie) {
  PulseErrors unit;
  EXPECT_EQ(unit.p99(), 0ns);
  for (int i = 0; i < 99; ++i) unit.add(i % 2 == 0 ? 4500ns : -4500ns);
  unit.add(3ms);
  EXPECT_EQ(unit.p99(), 5us);
  EXPECT_EQ(unit.max(), 3ms);
}

TEST(PulseErrors, AreToldAboveAMillisecondAsWellWithinASixtyFourth) {
  for (std::int64_t us = 1; us < 65536; us += us / 7 + 1) {
    PulseErrors unit;
    for (int i = 0; i < 100; ++i) unit.add(std::chrono::microseconds(us));
    unit.add(200ms);
    EXPECT_GE(unit.p99(), std::chrono::microseconds(us));
    EXPECT_LE(unit.p99(), std::chrono::microseconds(us + 1 + us / 64)) << us;
  }
  PulseErrors beyond;
  for (int i = 0; i < 100; ++i) beyond.add(300ms);
  EXPECT_GE(beyond.p99(), 65ms) << "beyond the last bin";
  EXPECT_LE(beyond.p99(), 300ms);
}

TEST(GpioPanTilt, MeasuresWhatALineThatIsLateAddsToItsPulses) {
  Head head({});
  head.pan.late_to_fall = head.tilt.late_to_fall = 3ms;
  const std::size_t before = widths(head.pan).size() + 1;
  wait_for_pulses(head.pan, before + 50);
  const HeadState state = head.unit->state();
  EXPECT_GE(state.pulse_error_max, 3ms);
  EXPECT_GE(state.pulse_error_p99, 3ms);
}

}  // namespace
}  // namespace ninedot
