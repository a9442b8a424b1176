#include "drivers/camera/reopening_source.h"

#include <gtest/gtest.h>

#include <deque>
#include <functional>
#include <mutex>
#include <optional>

namespace ninedot {
namespace {

using namespace std::chrono_literals;

constexpr auto kPeriod = 4ms;

/// A device whose every answer is scripted; it checks that it is used as its contract says.
class ScriptedDevice final : public CameraDevice {
 public:
  struct Answer {
    GrabbedFrame frame{};
    Errc failure{};  // 0: the frame
    int os_errno = 0;
  };

  // Shared with the test, guarded by `mutex`.
  struct Script {
    std::mutex mutex;
    std::deque<Answer> answers;  // empty: silence
    int refuse_openings = 0;
    int refusal = ENODEV;
    std::chrono::milliseconds opening_takes{0};
    std::vector<MonoTime> openings;
    int closings = 0, lent = 0, refreshed = 0;
    std::optional<std::chrono::nanoseconds> refresh_pause;
    bool is_open = false;

    void add(const Answer& answer) {
      const std::lock_guard lock(mutex);
      answers.push_back(answer);
    }
    template <typename T>
    T read(T Script::*member) {
      const std::lock_guard lock(mutex);
      return this->*member;
    }
  };

  explicit ScriptedDevice(Script& script) : script_(script) {}
  void open() override {
    std::this_thread::sleep_for(script_.read(&Script::opening_takes));
    const std::lock_guard lock(script_.mutex);
    EXPECT_FALSE(script_.is_open);
    script_.openings.push_back(mono_now());
    if (script_.refuse_openings > 0) {
      --script_.refuse_openings;
      throw CameraRefused("/dev/scripted: no such camera", script_.refusal);
    }
    script_.is_open = true;
  }
  void close() noexcept override {
    const std::lock_guard lock(script_.mutex);
    EXPECT_EQ(script_.lent, 0) << "closed while a buffer was lent";
    if (script_.is_open) ++script_.closings;
    script_.is_open = false;
  }
  std::string description() const override { return "scripted"; }
  std::chrono::nanoseconds frame_period() const noexcept override { return kPeriod; }
  Result<GrabbedFrame> grab(MonoTime deadline) noexcept override {
    {
      const std::lock_guard lock(script_.mutex);
      EXPECT_TRUE(script_.is_open);
      if (!script_.answers.empty()) {
        const Answer answer = script_.answers.front();
        script_.answers.pop_front();
        if (answer.failure != Errc{}) return fail(answer.failure, "scripted", answer.os_errno);
        ++script_.lent;
        return answer.frame;
      }
    }
    std::this_thread::sleep_until(deadline);
    return fail(Errc::kNoFrame, "no frame in time");
  }
  void release(std::uint32_t) noexcept override {
    const std::lock_guard lock(script_.mutex);
    --script_.lent;
  }
  std::optional<std::chrono::nanoseconds> refresh() noexcept override {
    const std::lock_guard lock(script_.mutex);
    EXPECT_TRUE(script_.is_open);
    ++script_.refreshed;
    return script_.refresh_pause;
  }

 private:
  Script& script_;
};

using Script = ScriptedDevice::Script;

ReopenOptions quick() {
  ReopenOptions options;
  options.first_frame_within = 60ms;
  options.first_pause = 5ms;
  options.longest_pause = 40ms;
  return options;
}

ScriptedDevice::Answer frame(std::uint32_t sequence, std::uint32_t skipped = 0, std::uint32_t flagged = 0) {
  ScriptedDevice::Answer answer;
  answer.frame.sequence = sequence;
  answer.frame.skipped = skipped;
  answer.frame.flagged = flagged;
  return answer;
}

/// Asks until there is a frame. \return  how often it was refused with kCameraLost
int ask_until_frame(ReopeningSource& source) {
  int lost = 0;
  for (const MonoTime give_up = mono_now() + 5s; mono_now() < give_up;) {
    const Result<FrameLease> lease = source.next(mono_now() + 5ms);
    if (lease) return lost;
    if (lease.error().code == Errc::kCameraLost) ++lost;
  }
  ADD_FAILURE() << "no frame any more";
  return lost;
}

TEST(ReopeningSource, CountsGapsSkippedAndFlaggedFramesOnceEach) {
  Script script;
  ReopeningSource source(std::make_unique<ScriptedDevice>(script), quick());
  struct Case {
    ScriptedDevice::Answer answer;
    std::uint64_t number;
    std::uint32_t dropped;
  };
  const std::vector<Case> cases{
      {frame(7), 0, 0},
      {frame(8), 1, 0},
      {frame(11), 4, 2},            // a gap of two
      {frame(14, 2), 7, 2},         // two newer ones won: the same gap
      {frame(17, 1, 1), 10, 1},     // one of the two was damaged
      {frame(17, 1), 12, 1},        // a driver that does not count
      {frame(0xFFFFFFFFU), 13, 0},  // counting backwards: started anew
      {frame(0), 14, 0},            // wraps
  };
  for (const Case& step : cases) {
    script.add(step.answer);
    const Result<FrameLease> lease = source.next(mono_now() + 1s);
    ASSERT_TRUE(lease);
    EXPECT_EQ(lease->frame.number, step.number);
    EXPECT_EQ(lease->dropped_before, step.dropped) << step.number;
  }
  EXPECT_EQ(source.counters().flagged, 1U);
  EXPECT_EQ(source.counters().restarts, 0U);
}

TEST(ReopeningSource, ASilentStallIsNoticedWithinTenFramePeriodsAndTheCameraIsOpenedAgain) {
  Script script;
  ReopeningSource source(std::make_unique<ScriptedDevice>(script), quick());
  script.add(frame(1));
  ask_until_frame(source);
  const MonoTime last_frame = mono_now();
  Result<FrameLease> lease = source.next(mono_now() + 10ms);
  EXPECT_EQ(lease.error().code, Errc::kNoFrame) << "not yet";
  lease = source.next(mono_now() + 10s);
  EXPECT_EQ(lease.error().code, Errc::kCameraLost);
  EXPECT_GE(mono_now() - last_frame, 9 * kPeriod);
  EXPECT_LT(mono_now() - last_frame, 10 * kPeriod + 200ms);  // a busy machine's patience
  script.add(frame(2));
  ask_until_frame(source);
  EXPECT_EQ(source.counters().restarts, 1U);
  EXPECT_EQ(script.read(&Script::closings), 1);
}

TEST(ReopeningSource, AFailingDeviceIsClosedAndOpenedAgainAndFrameNumbersGoOn) {
  Script script;
  ReopeningSource source(std::make_unique<ScriptedDevice>(script), quick());
  for (int round = 1; round <= 3; ++round) {
    script.add(frame(1));
    script.add({.failure = Errc::kCameraLost, .os_errno = ENODEV});
    ask_until_frame(source);
    const Result<FrameLease> lost = source.next(mono_now() + 1s);
    ASSERT_FALSE(lost);
    EXPECT_EQ(lost.error().code, Errc::kCameraLost);
    EXPECT_EQ(lost.error().os_errno, ENODEV);
    script.add(frame(0));
    ask_until_frame(source);
    EXPECT_EQ(source.counters().restarts, static_cast<std::uint32_t>(round));
  }
  script.add(frame(1));
  EXPECT_EQ(source.next(mono_now() + 1s)->frame.number, 6U);
}

TEST(ReopeningSource, SaysInPlainWordsThatTheSignalIsMissing) {
  Script script;
  ReopeningSource source(std::make_unique<ScriptedDevice>(script), quick());
  script.add(frame(1));
  ask_until_frame(source);
  {
    const std::lock_guard lock(script.mutex);
    script.refusal = ENOLINK;
    script.refuse_openings = 1000;
  }
  script.add({.failure = Errc::kCameraLost, .os_errno = EPIPE});
  std::string said;
  for (const MonoTime give_up = mono_now() + 5s; mono_now() < give_up && said.find("signal") == std::string::npos;) {
    const Result<FrameLease> lease = source.next(mono_now() + 5ms);
    if (!lease) said = lease.error().text;
  }
  EXPECT_EQ(said, "no usable signal at the camera's input: check cable, power and video mode");
}

TEST(ReopeningSource, WhileTheCameraIsGoneTheCallerIsAnsweredInTimeEvenIfOpeningBlocks) {
  Script script;
  ReopeningSource source(std::make_unique<ScriptedDevice>(script), quick());
  script.add(frame(1));
  ask_until_frame(source);
  {
    const std::lock_guard lock(script.mutex);
    script.opening_takes = 150ms;
    script.answers.push_back({.failure = Errc::kCameraLost});
  }
  EXPECT_FALSE(source.next(mono_now() + 1s));
  for (int i = 0; i < 10; ++i) {
    const MonoTime asked = mono_now();
    const Result<FrameLease> lease = source.next(asked + 5ms);
    ASSERT_FALSE(lease);
    EXPECT_EQ(lease.error().code, Errc::kCameraLost);
    EXPECT_LT(mono_now() - asked, 100ms);
  }
  script.add(frame(2));
  EXPECT_GT(ask_until_frame(source), 0);
}

TEST(ReopeningSource, TheBackOffDoublesUpToItsLimitAndStartsAnewAfterAFrame) {
  Script script;
  ReopeningSource source(std::make_unique<ScriptedDevice>(script), quick());
  script.add(frame(1));
  ask_until_frame(source);
  {
    const std::lock_guard lock(script.mutex);
    script.refuse_openings = 6;
    script.answers.push_back({.failure = Errc::kCameraLost});
    script.answers.push_back(frame(2));
  }
  ask_until_frame(source);
  const std::vector<MonoTime> openings = script.read(&Script::openings);
  ASSERT_EQ(openings.size(), 8U);                              // the first, six refused, the one that worked
  const std::array least{10ms, 20ms, 40ms, 40ms, 40ms, 40ms};  // the first pause was before openings[1]
  for (std::size_t i = 0; i < least.size(); ++i) EXPECT_GE(openings[i + 2] - openings[i + 1], least[i]) << i;
  EXPECT_EQ(source.counters().restarts, 1U);
  script.add({.failure = Errc::kCameraLost});
  const MonoTime lost_at = mono_now();
  script.add(frame(3));
  ask_until_frame(source);
  EXPECT_LT(script.read(&Script::openings).back() - lost_at, 35ms + 200ms);
}

TEST(ReopeningSource, IsNotClosedBeforeTheLastLeaseIsBack) {
  Script script;
  ReopeningSource source(std::make_unique<ScriptedDevice>(script), quick());
  script.add(frame(1));
  Result<FrameLease> held = source.next(mono_now() + 1s);
  ASSERT_TRUE(held);
  script.add({.failure = Errc::kCameraLost});
  EXPECT_FALSE(source.next(mono_now() + 1s));
  std::this_thread::sleep_for(30ms);
  EXPECT_TRUE(script.read(&Script::is_open)) << "the pixels of the lease are the device's";
  *held = FrameLease();
  script.add(frame(2));
  ask_until_frame(source);
  EXPECT_EQ(script.read(&Script::closings), 1);
}

TEST(ReopeningSource, ADamagedFrameIsNoLoss) {
  Script script;
  ReopeningSource source(std::make_unique<ScriptedDevice>(script), quick());
  script.add({.failure = Errc::kFrameUnreadable});
  EXPECT_EQ(source.next(mono_now() + 1s).error().code, Errc::kFrameUnreadable);
  script.add(frame(1));
  EXPECT_TRUE(source.next(mono_now() + 1s));
  EXPECT_EQ(script.read(&Script::closings), 0);
}

TEST(ReopeningSource, RefusesAtTheStartUnlessToldToWait) {
  Script script;
  script.refuse_openings = 2;
  EXPECT_THROW(ReopeningSource(std::make_unique<ScriptedDevice>(script), quick()), CameraRefused);
  ReopenOptions options = quick();
  options.wait_for_device = true;
  ReopeningSource source(std::make_unique<ScriptedDevice>(script), options);
  const Result<FrameLease> lease = source.next(mono_now());
  EXPECT_TRUE(lease.has_value() || lease.error().code == Errc::kCameraLost);
  script.add(frame(1));
  ask_until_frame(source);
  EXPECT_EQ(source.counters().restarts, 0U) << "the first opening is no restart";
}

TEST(ReopeningSource, TellsTheNewestRefusalUntilTheCameraIsOpen) {
  Script script;
  script.refuse_openings = 1'000'000;  // until it is told otherwise
  ReopenOptions options = quick();
  options.wait_for_device = true;
  ReopeningSource source(std::make_unique<ScriptedDevice>(script), options);
  EXPECT_EQ(source.last_refusal(), "/dev/scripted: no such camera");
  script.add(frame(1));
  {
    const std::lock_guard lock(script.mutex);
    script.refuse_openings = 0;
  }
  ask_until_frame(source);
  EXPECT_EQ(source.last_refusal(), "");
  EXPECT_EQ(source.description(), "scripted");
  EXPECT_GE(script.read(&Script::openings).size(), 2U);
}

TEST(ReopeningSource, AsksARunningDeviceWhatChangedAsOftenAsItWants) {
  Script script;
  script.refresh_pause = 5ms;
  ReopeningSource source(std::make_unique<ScriptedDevice>(script), quick());
  for (const MonoTime give_up = mono_now() + 5s; mono_now() < give_up && script.read(&Script::refreshed) < 4;)
    std::this_thread::sleep_for(1ms);
  EXPECT_GE(script.read(&Script::refreshed), 4);
  {
    const std::lock_guard lock(script.mutex);
    script.refresh_pause.reset();
    script.answers.push_back({.failure = Errc::kCameraLost});
    script.answers.push_back(frame(1));
  }
  ask_until_frame(source);  // opened anew: asked once, and then no more
  std::this_thread::sleep_for(20ms);
  const int asked = script.read(&Script::refreshed);
  std::this_thread::sleep_for(30ms);
  EXPECT_EQ(script.read(&Script::refreshed), asked);
}

TEST(ReopeningSource, EndsAtOnceWhileLost) {
  Script script;
  script.refuse_openings = 1000;
  ReopenOptions options = quick();
  options.wait_for_device = true;
  options.first_pause = options.longest_pause = 60s;
  const MonoTime begin = mono_now();
  { const ReopeningSource source(std::make_unique<ScriptedDevice>(script), options); }
  EXPECT_LT(mono_now() - begin, 5s);
}

}  // namespace
}  // namespace ninedot
