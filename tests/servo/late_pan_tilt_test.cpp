#include "drivers/servo/late_pan_tilt.h"

#include <gtest/gtest.h>

#include <mutex>
#include <thread>
#include <vector>

#include "tests/support/allocation_counter.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

/// A head whose cable the test pulls.
struct Cable {
  std::atomic<bool> is_there{false}, is_broken{false};
  std::atomic<int> attempts{0}, openings{0}, closings{0};
  std::atomic<double> pan_rad{-1}, taken_to_be_at_rad{-1};
};

class CableHead final : public PanTilt {
 public:
  explicit CableHead(Cable& cable) : cable_(cable) { ++cable_.openings; }
  ~CableHead() override { ++cable_.closings; }
  void move_to(const HeadAngles& angles) noexcept override {
    state_.failed = cable_.is_broken || !cable_.is_there;
    if (state_.failed) return;
    state_.angles = angles;
    cable_.pan_rad = angles.pan_rad;
  }
  void stop() noexcept override {}
  HeadState state() const noexcept override { return state_; }

 private:
  Cable& cable_;
  HeadState state_;
};

LatePanTilt::Open opener(Cable& cable) {
  return [&cable](const HeadAngles& at) -> std::unique_ptr<PanTilt> {
    ++cable.attempts;
    cable.taken_to_be_at_rad = at.pan_rad;
    if (!cable.is_there) throw DeviceAbsent("no such head");
    return std::make_unique<CableHead>(cable);
  };
}

/// Impatient, so that tests are short.
LatePanTiltOptions soon() {
  LatePanTiltOptions options;
  options.start = {0.25, -0.5};
  options.backoff = Backoff(2ms, 10ms);
  return options;
}

/// As the frame loop: says its target again and again until something is so.
bool eventually(LatePanTilt& head, double pan_rad, const std::function<bool()>& condition) {
  const MonoTime until = mono_now() + 10s;
  while (!condition() && mono_now() < until) {
    head.move_to({pan_rad, 0});
    std::this_thread::sleep_for(1ms);
  }
  return condition();
}

TEST(LatePanTilt, IsTheHeadItselfWhenItIsThereAtTheStart) {
  Cable cable;
  cable.is_there = true;
  LatePanTilt head(opener(cable), soon());
  EXPECT_EQ(cable.openings, 1) << "at once, so that the first frame finds it";
  EXPECT_EQ(cable.taken_to_be_at_rad, 0.25);
  EXPECT_FALSE(head.state().absent);
  EXPECT_FALSE(head.state().failed);
  EXPECT_EQ(head.problem(), "");
  head.move_to({0.5, 0});
  EXPECT_EQ(cable.pan_rad, 0.5);
  EXPECT_EQ(head.state().angles.pan_rad, 0.5);
}

TEST(LatePanTilt, HasFailedUntilTheHeadComesAndThenGoesWhereItIsWanted) {
  Cable cable;
  LatePanTilt head(opener(cable), soon());
  EXPECT_TRUE(head.state().failed);
  EXPECT_EQ(head.state().angles.tilt_rad, -0.5) << "where it is taken to be";
  EXPECT_EQ(head.problem(), "no such head");
  head.move_to({0.5, 0});
  head.stop();
  EXPECT_TRUE(head.state().failed);
  cable.is_there = true;
  EXPECT_TRUE(eventually(head, 0.5, [&] { return cable.pan_rad == 0.5; }));
  EXPECT_FALSE(head.state().failed);
  EXPECT_EQ(head.problem(), "");
  EXPECT_EQ(cable.openings, 1);
}

TEST(LatePanTilt, ClosesAHeadThatWentAndOpensItWhenItIsBack) {
  Cable cable;
  cable.is_there = true;
  LatePanTilt head(opener(cable), soon());
  for (int round = 1; round <= 2; ++round) {
    cable.is_there = false;
    EXPECT_TRUE(eventually(head, 0.1, [&] { return cable.closings == round && head.problem() == "no such head"; }));
    EXPECT_TRUE(head.state().failed && head.state().absent);
    cable.is_there = true;
    EXPECT_TRUE(eventually(head, 0.2 * round, [&] { return cable.pan_rad == 0.2 * round; }));
    EXPECT_FALSE(head.state().failed);
    EXPECT_EQ(cable.openings, round + 1);
    EXPECT_EQ(cable.taken_to_be_at_rad, round == 1 ? 0.0 : 0.2) << "where it was last, not where it starts";
  }
}

TEST(LatePanTilt, DoesNotCloseAHeadForOneCommandThatFailed) {
  Cable cable;
  cable.is_there = true;
  LatePanTilt head(opener(cable), soon());
  for (int i = 0; i < 5; ++i) {
    cable.is_broken = true;
    head.move_to({0.1, 0});
    EXPECT_TRUE(head.state().failed);
    std::this_thread::sleep_for(300ms);
    cable.is_broken = false;
    head.move_to({0.1, 0});
    EXPECT_FALSE(head.state().failed);
  }
  EXPECT_EQ(cable.closings, 0);
}

TEST(LatePanTilt, LeavesAHeadAloneThatComesBackByItself) {
  Cable cable;
  cable.is_there = true;
  LatePanTiltOptions options = soon();
  options.reopens_failed = false;
  LatePanTilt head(opener(cable), options);
  cable.is_broken = true;
  const MonoTime begun = mono_now();
  eventually(head, 0.1, [&] { return mono_now() - begun > LatePanTilt::kGiveUpAfter + 200ms; });
  EXPECT_EQ(cable.closings, 0);
  EXPECT_TRUE(head.state().failed);
  EXPECT_NE(head.problem().find("does not answer"), std::string::npos);
  cable.is_broken = false;
  head.move_to({0.1, 0});
  EXPECT_FALSE(head.state().failed);
  EXPECT_EQ(head.problem(), "");
}

TEST(LatePanTilt, IsNotOpenedWhileItMustNotMove) {
  Cable cable;
  cable.is_there = true;
  std::atomic<bool> may_move{false};
  LatePanTiltOptions options = soon();
  options.may_move = [&] { return may_move.load(); };
  LatePanTilt head(opener(cable), options);
  const MonoTime begun = mono_now();
  eventually(head, 0.5, [&] { return mono_now() - begun > 100ms; });
  EXPECT_EQ(cable.attempts, 0) << "opening may move it";
  EXPECT_FALSE(head.state().failed) << "nothing is known to be wrong with it";
  EXPECT_NE(head.problem().find("inhibit"), std::string::npos);
  may_move = true;
  EXPECT_TRUE(eventually(head, 0.5, [&] { return cable.pan_rad == 0.5; }));
  EXPECT_EQ(head.problem(), "");
}

TEST(LatePanTilt, RefusesWhatWaitingWouldNotMend) {
  const auto open = [](const HeadAngles& /*at*/) -> std::unique_ptr<PanTilt> {
    throw StartupError(ExitStatus::kWrongUsage, "no channel 7");
  };
  EXPECT_THROW(LatePanTilt(open, soon()), StartupError);
}

TEST(LatePanTilt, NeverMakesItsCallerWaitOrAllocate) {
  Cable cable;
  cable.is_there = true;
  // A head that takes a second to open: neither that nor its absence is the caller's business.
  std::atomic<bool> is_slow{false};
  LatePanTilt head(
      [&](const HeadAngles& at) -> std::unique_ptr<PanTilt> {
        if (is_slow) std::this_thread::sleep_for(1s);
        return opener(cable)(at);
      },
      soon());
  is_slow = true;
  cable.is_there = false;
  std::chrono::nanoseconds longest{};
  {
    const test::AllocationGuard guard;
    const MonoTime until = mono_now() + LatePanTilt::kGiveUpAfter + 1s;
    while (mono_now() < until) {
      const MonoTime begun = mono_now();
      head.move_to({0.1, 0.1});
      (void)head.state();
      longest = std::max(longest, mono_now() - begun);
      std::this_thread::sleep_for(1ms);
    }
    EXPECT_EQ(guard.allocations(), 0U);
    EXPECT_EQ(guard.releases(), 0U);
  }
  EXPECT_TRUE(head.state().failed);
  EXPECT_EQ(cable.closings, 1);
  EXPECT_LT(longest, 500ms);
}

}  // namespace
}  // namespace ninedot
