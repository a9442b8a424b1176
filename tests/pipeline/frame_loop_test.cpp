#include "pipeline/frame_loop.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <vector>

#include "outputs/wire_output.h"
#include "pipeline/report_reason.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

/// Answers what the test put down, one entry per call; then "no frame".
class ScriptedSource final : public FrameSource, private FrameOwner {
 public:
  struct Entry {
    Errc failure{};  // 0: a frame
    std::uint64_t frame_number = 0;
    std::uint32_t dropped_before = 0;
  };
  explicit ScriptedSource(std::vector<Entry> script) : script_(std::move(script)) {}

  Result<FrameLease> next(MonoTime deadline) noexcept override {
    if (at_ == script_.size()) {
      std::this_thread::sleep_until(deadline);
      return fail(Errc::kNoFrame, "the script is over");
    }
    const Entry& entry = script_[at_++];
    if (entry.failure != Errc{}) return fail(entry.failure, "as the test wants it", 5);
    FrameLease lease(this, 0);
    lease.frame.luma = {pixels_.data(), 4, 4, 4};
    lease.frame.number = entry.frame_number;
    lease.frame.set_exposure(mono_now() - 3ms);
    lease.dropped_before = entry.dropped_before;
    lease.frame.head = HeadAngles{0.25, 0};
    ++lent;
    return lease;
  }

  SourceCounters counters() const noexcept override { return counted; }

  int lent = 0;
  SourceCounters counted;

 private:
  void give_back(std::uint32_t) noexcept override { --lent; }
  std::array<std::uint8_t, 16> pixels_{};
  std::vector<Entry> script_;
  std::size_t at_ = 0;
};

/// Even frames show a landmark at x = frame number, odd ones none.
class EvenFramesAreFound final : public FrameProcessor {
 public:
  const Fix& process(const Frame& frame) noexcept override {
    fix_ = Fix{};
    if (frame.number % 2 != 0) return fix_;
    fix_.found = true;
    fix_.reason = Reason::kNone;
    LandmarkFix landmark;
    (void)landmark.candidates.list.try_push_back({});
    landmark.quality = 900;
    landmark.T_world_camera.translation_m.x() = static_cast<double>(frame.number);
    (void)fix_.landmarks.try_push_back(landmark);
    return fix_;
  }

 private:
  Fix fix_;
};

/// Keeps what a frame says of its zoom.
class ZoomKeeper final : public FrameProcessor {
 public:
  const Fix& process(const Frame& frame) noexcept override {
    zoom = frame.zoom;
    return fix_;
  }
  double zoom = 0;

 private:
  Fix fix_;
};

class OrdinaryThread final : public FrameThread {
 public:
  explicit OrdinaryThread(int os_errno) : os_errno_(os_errno) {}
  Result<void> enter() noexcept override {
    if (os_errno_ != 0) return fail(Errc::kIo, "refused", os_errno_);
    return {};
  }

 private:
  int os_errno_;
};

struct Bench {
  explicit Bench(std::initializer_list<ScriptedSource::Entry> script) : Bench(std::vector(script)) {}
  explicit Bench(std::vector<ScriptedSource::Entry> script, FrameLoopOptions options = quick())
      : source(std::move(script)), loop(source, processor, reports, health, options) {}
  static FrameLoopOptions quick() { return {.wait = 1ms, .stall_after = 20ms, .health_period = 10ms}; }

  ScriptedSource source;
  EvenFramesAreFound processor;
  Mailbox<Report> reports;
  Mailbox<Health> health;
  FrameLoop loop;
};

TEST(FrameLoop, SaysThatItIsStartingBeforeTheFirstFrame) {
  Bench bench({});
  EXPECT_EQ(bench.reports.read().reason, Reason::kStarting);
  EXPECT_FALSE(bench.reports.read().valid);
}

TEST(FrameLoop, PublishesEveryFrameWithItsLatencyAndGivesTheBufferBack) {
  Bench bench({{.frame_number = 4}});
  EXPECT_TRUE(bench.loop.step());
  const Report report = bench.reports.read();
  EXPECT_TRUE(report.valid);
  EXPECT_EQ(report.frame_number, 4U);
  EXPECT_GE(report.latency, 3ms);
  EXPECT_LT(report.latency, 1s);
  EXPECT_GE(report.published_at, report.exposed_at + 3ms);
  EXPECT_EQ(report.head.pan_rad, 0.25);
  EXPECT_FALSE(report.head.present) << "a recording's angles are no head";
  EXPECT_EQ(bench.source.lent, 0);
  EXPECT_EQ(bench.loop.frames_processed(), 1U);
}

/// Writes down what the world was like when it was shown a frame.
class Onlooker final : public FrameObserver {
 public:
  Onlooker(const Mailbox<Report>& reports, const ScriptedSource& source) : reports_(reports), source_(source) {}
  void observe(const Frame& frame, const Fix& fix, const FrameProcessor&, const Report& report) noexcept override {
    seen.push_back({frame.number, fix.found, report.frame_number == reports_.read().frame_number, source_.lent});
  }
  struct Sight {
    std::uint64_t number;
    bool found, is_published;
    int lent;
  };
  std::vector<Sight> seen;

 private:
  const Mailbox<Report>& reports_;
  const ScriptedSource& source_;
};

TEST(FrameLoop, ShowsEachFrameOnceItsReportIsOutAndBeforeItsBufferGoesBack) {
  ScriptedSource source({{.frame_number = 4}, {.failure = Errc::kFrameUnreadable}, {.frame_number = 5}});
  EvenFramesAreFound processor;
  Mailbox<Report> reports;
  Mailbox<Health> health;
  Onlooker onlooker(reports, source);
  FrameLoopOptions options;
  options.observer = &onlooker;
  FrameLoop loop(source, processor, reports, health, options);
  for (int i = 0; i < 3; ++i) loop.step();
  ASSERT_EQ(onlooker.seen.size(), 2U) << "a frame that failed is none";
  EXPECT_EQ(onlooker.seen[0].number, 4U);
  EXPECT_TRUE(onlooker.seen[0].found && onlooker.seen[0].is_published && onlooker.seen[1].is_published);
  EXPECT_EQ(onlooker.seen[0].lent, 1);
  EXPECT_FALSE(onlooker.seen[1].found);
  EXPECT_EQ(source.lent, 0);
}

TEST(FrameLoop, ThePoseSequenceCountsFramesWithAValidPoseAlone) {
  Bench bench({{.frame_number = 2},
               {.frame_number = 3},
               {.failure = Errc::kCameraLost},
               {.frame_number = 4},
               {.frame_number = 6}});
  std::vector<std::uint32_t> sequences;
  for (int i = 0; i < 5; ++i) {
    bench.loop.step();
    sequences.push_back(bench.reports.read().pose_sequence);
  }
  EXPECT_EQ(sequences, (std::vector<std::uint32_t>{1, 1, 1, 2, 3}));
}

TEST(FrameLoop, AStalePoseKeepsItsValuesAndItsTimeButIsNotValid) {
  Bench bench({{.frame_number = 2}, {.frame_number = 3}});
  bench.loop.step();
  const Report fresh = bench.reports.read();
  bench.loop.step();
  const Report stale = bench.reports.read();
  EXPECT_FALSE(stale.valid);
  EXPECT_EQ(stale.reason, Reason::kNoLandmark);
  EXPECT_EQ(stale.quality, 0);
  EXPECT_EQ(stale.camera_in_world.position_m[0], 2);
  EXPECT_EQ(stale.exposed_at, fresh.exposed_at);
  EXPECT_EQ(stale.pose_sequence, fresh.pose_sequence);
  EXPECT_EQ(stale.frames.processed, fresh.frames.processed + 1);
}

TEST(FrameLoop, CountsDroppedAndFailedFrames) {
  Bench bench({{.frame_number = 2, .dropped_before = 3},
               {.failure = Errc::kFrameUnreadable},
               {.failure = Errc::kFrameSize},
               {.frame_number = 4, .dropped_before = 1}});
  for (int i = 0; i < 4; ++i) bench.loop.step();
  std::this_thread::sleep_for(12ms);
  bench.loop.step();
  const FrameCounts frames = bench.reports.read().frames;
  EXPECT_EQ(frames.dropped, 4U);
  EXPECT_EQ(frames.failed, 2U);
  EXPECT_EQ(frames.processed, 2U);
  const Health health = bench.health.read();
  EXPECT_GE(health.latency_median, 3ms);
  EXPECT_GE(health.latency_max, health.latency_median);
}

TEST(FrameLoop, HealthTellsTheCamerasRestartsAndItsDamagedBuffers) {
  Bench bench({{.frame_number = 2}, {.failure = Errc::kFrameUnreadable}, {.failure = Errc::kCameraLost}});
  bench.source.counted = {.restarts = 2, .flagged = 3};
  for (int i = 0; i < 3; ++i) bench.loop.step();
  EXPECT_EQ(bench.health.read().camera_restarts, 2U);
  EXPECT_EQ(bench.health.read().frames_flagged, 3U);
  EXPECT_EQ(bench.reports.read().frames.failed, 1U) << "the unreadable one";
  bench.source.counted = {.restarts = 3, .flagged = 4};
  std::this_thread::sleep_for(12ms);
  bench.loop.step();
  EXPECT_EQ(bench.health.read().camera_restarts, 3U);
  EXPECT_EQ(bench.health.read().frames_flagged, 4U);
}

TEST(FrameLoop, TurnsGrowWhileTheCameraIsLostAndFramesDoNot) {
  Bench bench(std::vector<ScriptedSource::Entry>(3, {.failure = Errc::kCameraLost}));
  for (int i = 0; i < 3; ++i) bench.loop.step();
  EXPECT_EQ(bench.loop.turns(), 3U);
  EXPECT_EQ(bench.loop.frames_processed(), 0U);
}

TEST(FrameLoop, EveryFailureOfTheSourceBecomesAReportWithItsReason) {
  const std::array<std::pair<Errc, Reason>, 4> cases{{{Errc::kCameraLost, Reason::kCameraLost},
                                                      {Errc::kFrameSize, Reason::kFrameSize},
                                                      {Errc::kFrameUnreadable, Reason::kFrameUnreadable},
                                                      {Errc::kEndOfStream, Reason::kStopped}}};
  for (const auto& [errc, reason] : cases) {
    Bench bench({{.frame_number = 2}, {.failure = errc}});
    bench.loop.step();
    ASSERT_TRUE(bench.reports.read().valid);
    const bool goes_on = bench.loop.step();
    EXPECT_EQ(goes_on, errc != Errc::kEndOfStream);
    EXPECT_EQ(bench.loop.over(), errc == Errc::kEndOfStream);
    EXPECT_FALSE(bench.reports.read().valid);
    EXPECT_EQ(bench.reports.read().reason, reason);
    EXPECT_EQ(bench.loop.last_error().code, errc);
    EXPECT_EQ(bench.loop.last_error().os_errno, 5);
    EXPECT_EQ(bench.loop.frames_processed(), 1U) << "a failure is no frame";
  }
}

TEST(FrameLoop, EveryErrorCodeHasAReasonThatIsNotNone) {
  for (const Errc code : {Errc::kNoFrame, Errc::kEndOfStream, Errc::kCameraLost, Errc::kFrameSize,
                          Errc::kFrameUnreadable, Errc::kNoLandmark, Errc::kPoseDegenerate, Errc::kIo})
    EXPECT_NE(reason_of(code), Reason::kNone);
}

TEST(FrameLoop, ACameraThatDeliversNothingIsLostAfterTheStallTimeAndNoFrameIsNoFaultBefore) {
  Bench bench({{.frame_number = 2}});
  bench.loop.step();
  const MonoTime frame_at = bench.reports.read().published_at;
  while (bench.reports.read().valid && mono_now() < frame_at + 5s) bench.loop.step();
  EXPECT_GE(mono_now() - frame_at, 19ms);
  EXPECT_EQ(bench.reports.read().reason, Reason::kCameraLost);
  EXPECT_EQ(bench.loop.last_error().code, Errc::kCameraLost);
  const std::uint64_t version = bench.reports.version();
  bench.loop.step();
  EXPECT_EQ(bench.reports.version(), version) << "published on change only";
}

TEST(FrameLoop, RecoversByItselfAfterAFailure) {
  Bench bench({{.frame_number = 2}, {.failure = Errc::kCameraLost}, {.frame_number = 6}});
  for (int i = 0; i < 3; ++i) bench.loop.step();
  EXPECT_TRUE(bench.reports.read().valid);
  EXPECT_EQ(bench.reports.read().camera_in_world.position_m[0], 6);
}

TEST(FrameLoop, FailuresThatComeAtOnceDoNotSpin) {
  Bench bench(std::vector<ScriptedSource::Entry>(10, {.failure = Errc::kCameraLost}));
  const MonoTime begin = mono_now();
  for (int i = 0; i < 10; ++i) bench.loop.step();
  EXPECT_GE(mono_now() - begin, 49ms);
}

TEST(FrameLoop, HealthKnowsTheFrameRateAndTheTemperature) {
  std::vector<ScriptedSource::Entry> script;
  for (std::uint64_t i = 0; i < 20; ++i) script.push_back({.frame_number = 2 * i});
  Bench bench(std::move(script));
  EXPECT_TRUE(std::isnan(bench.health.read().temperature_degC));
  bench.loop.set_temperature(51.5);
  for (int i = 0; i < 20; ++i) {
    std::this_thread::sleep_for(5ms);
    bench.loop.step();
  }
  const Health health = bench.health.read();
  EXPECT_GT(health.frame_rate_hz, 20);
  EXPECT_LE(health.frame_rate_hz, 201);
  EXPECT_EQ(health.temperature_degC, 51.5);
}

TEST(FrameLoop, RunsOnItsOwnThreadUntilToldToStopAndSaysWhetherItIsRealTime) {
  for (const int refused : {0, 1}) {
    Bench bench({{.frame_number = 2}, {.frame_number = 4}});
    OrdinaryThread thread(refused);
    const Result<void> started = bench.loop.start(thread);
    EXPECT_EQ(started ? 0 : started.error().os_errno, refused);
    EXPECT_EQ(bench.health.read().realtime, refused == 0);
    const MonoTime begin = mono_now();
    while (bench.loop.frames_processed() < 2 && mono_now() < begin + 5s) std::this_thread::sleep_for(1ms);
    EXPECT_EQ(bench.loop.frames_processed(), 2U);
    bench.loop.stop();
    EXPECT_LT(mono_now() - begin, 5s);
  }
}

TEST(FrameLoop, TheRateFallsToZeroWithinTwoHealthPeriodsWhenFramesStop) {
  for (const Errc end : {Errc::kEndOfStream, Errc::kNoFrame}) {
    std::vector<ScriptedSource::Entry> script;
    for (std::uint64_t i = 0; i < 20; ++i) script.push_back({.frame_number = 2 * i});
    if (end != Errc::kNoFrame) script.push_back({.failure = end});
    FrameLoopOptions options = Bench::quick();
    options.health_period = 200ms;
    Bench bench(std::move(script), options);
    OrdinaryThread thread(0);
    EXPECT_TRUE(bench.loop.start(thread));
    const auto rate_hz = [&] {
      return frame_metrics(bench.reports.read(), bench.health.read(), mono_now())[MetricId::kFrameRate];
    };
    const MonoTime begin = mono_now();
    while (rate_hz() == 0 && mono_now() < begin + 5s) std::this_thread::sleep_for(1ms);
    EXPECT_GT(rate_hz(), 0);
    const MonoTime known_at = mono_now();
    while (rate_hz() != 0 && mono_now() < known_at + 5s) std::this_thread::sleep_for(1ms);
    EXPECT_LT(mono_now() - known_at, 2 * options.health_period + 300ms) << "and what a busy machine adds";
    // A loop that hangs in its source publishes nothing at all: its last word ends by itself.
    bench.loop.stop();
    const Health last = bench.health.read();
    Health of_a_good_second = last;
    of_a_good_second.frame_rate_hz = 35;
    const auto shown_hz = [&](MonoTime now) {
      return frame_metrics(bench.reports.read(), of_a_good_second, now)[MetricId::kFrameRate];
    };
    EXPECT_EQ(shown_hz(last.rate_holds_until), 35);
    EXPECT_EQ(shown_hz(last.rate_holds_until + 1ns), 0);
  }
}

TEST(FrameLoop, EveryReportCarriesItsOwnFrameCountAndAFrameOfAWrongSizeIsNotProcessed) {
  class WrongSize final : public FrameProcessor {
   public:
    const Fix& process(const Frame&) noexcept override { return fix_; }
    Fix fix_ = [] {
      Fix fix;
      fix.reason = Reason::kFrameSize;
      return fix;
    }();
  } processor;
  ScriptedSource source({{.frame_number = 1}, {.frame_number = 2}});
  Mailbox<Report> reports;
  Mailbox<Health> health;
  FrameLoop loop(source, processor, reports, health, Bench::quick());
  loop.step();
  EXPECT_EQ(reports.read().frames.processed, 0U);
  EXPECT_EQ(reports.read().frames.failed, 1U);
  EXPECT_EQ(loop.frames_processed(), 0U);
}

TEST(FrameLoop, StampsReportsWithWhereTheHeadStoodWhenTheFrameWasExposed) {
  Handoff<HeadSnapshot> head;
  FrameLoopOptions options = Bench::quick();
  options.head = &head;
  Bench bench({{.frame_number = 2}, {.frame_number = 3}}, options);
  HeadSnapshot snapshot;
  snapshot.track = HeadTrack({0.1, 0});
  snapshot.track.add(mono_now() - 1s, {0.2, 0});
  snapshot.track.add(mono_now() + 1h, {0.2, 0});
  snapshot.track.add(mono_now() + 2h, {0.3, 0});  // after any exposure of this test
  snapshot.state = AimState::kTrack;
  snapshot.order = 7;
  snapshot.progress = OrderProgress::kRunning;
  head.put(snapshot);
  bench.loop.step();
  ASSERT_TRUE(bench.reports.read().valid);
  EXPECT_TRUE(bench.reports.read().head.present);
  EXPECT_EQ(bench.reports.read().head.pan_rad, 0.2);
  EXPECT_EQ(bench.reports.read().head.order, 7U);
  EXPECT_EQ(bench.reports.read().head.state, AimState::kTrack);
  bench.loop.step();
  ASSERT_FALSE(bench.reports.read().valid);
  EXPECT_EQ(bench.reports.read().head.pan_rad, 0.3) << "without a pose: where it stands now";
}

TEST(FrameLoop, SaysWhetherThereIsAHeadBeforeTheFirstFrame) {
  Handoff<HeadSnapshot> head;
  FrameLoopOptions options = Bench::quick();
  options.head = &head;
  const Bench with({}, options);
  EXPECT_TRUE(with.reports.read().head.present);
  EXPECT_EQ(with.reports.read().reason, Reason::kStarting);
  const Bench without({});
  EXPECT_FALSE(without.reports.read().head.present);
}

TEST(FrameLoop, GoesOnTellingWhatTheHeadDoesWhenNoFramesComeAndAfterTheSourcesEnd) {
  for (const Errc end : {Errc::kCameraLost, Errc::kEndOfStream}) {
    Handoff<HeadSnapshot> head;
    FrameLoopOptions options = Bench::quick();
    options.head = &head;
    Bench bench({{.frame_number = 2}, {.failure = end}}, options);
    bench.loop.step();
    bench.loop.step();
    ASSERT_FALSE(bench.reports.read().valid);
    HeadSnapshot snapshot;
    snapshot.track.add(mono_now(), {0.5, 0});
    snapshot.progress = OrderProgress::kDone;
    head.put(snapshot);
    bench.loop.step();
    EXPECT_EQ(bench.reports.read().head.pan_rad, 0.5);
    EXPECT_EQ(bench.reports.read().head.progress, OrderProgress::kDone);
    const std::uint64_t version = bench.reports.version();
    bench.loop.step();
    EXPECT_EQ(bench.reports.version(), version) << "published on change only";
  }
}

TEST(FrameLoop, AValidReportKeepsTheHeadOfItsExposureUntilThereIsAnotherFrame) {
  Handoff<HeadSnapshot> head;
  FrameLoopOptions options = Bench::quick();
  options.head = &head;
  options.stall_after = 10s;
  Bench bench({{.frame_number = 2}}, options);
  bench.loop.step();
  const std::uint64_t version = bench.reports.version();
  HeadSnapshot snapshot;
  snapshot.track.add(mono_now(), {0.5, 0});
  head.put(snapshot);
  bench.loop.step();
  EXPECT_TRUE(bench.reports.read().valid);
  EXPECT_EQ(bench.reports.version(), version);
}

TEST(FrameLoop, EndsByItselfWhenTheSourceIsOver) {
  Bench bench({{.frame_number = 2}, {.failure = Errc::kEndOfStream}});
  OrdinaryThread thread(0);
  EXPECT_TRUE(bench.loop.start(thread));
  const MonoTime begin = mono_now();
  while (!bench.loop.over() && mono_now() < begin + 5s) std::this_thread::sleep_for(1ms);
  EXPECT_TRUE(bench.loop.over());
  EXPECT_EQ(bench.reports.read().reason, Reason::kStopped);
  EXPECT_EQ(bench.reports.read().camera_in_world.position_m[0], 2);
}

TEST(FrameLoop, StampsFramesWithTheZoomThatTheHeadTells) {
  ScriptedSource source({{}, {}, {}, {}});
  ZoomKeeper keeper;
  Mailbox<Report> reports;
  Mailbox<Health> healths;
  Handoff<HeadSnapshot> head;
  FrameLoopOptions options;
  options.head = &head;
  options.zoom_of_head = true;
  FrameLoop loop(source, keeper, reports, healths, options);
  loop.step();
  EXPECT_TRUE(std::isnan(keeper.zoom)) << "the head says nothing";
  HeadSnapshot snapshot;
  snapshot.zoom = ZoomStand{512, mono_now() - 1s, mono_now()};
  head.put(snapshot);
  loop.step();
  EXPECT_EQ(keeper.zoom, 512);
  snapshot.zoom->since = mono_now();
  head.put(snapshot);
  loop.step();
  EXPECT_TRUE(std::isnan(keeper.zoom)) << "it was on its way when the frame was exposed, 3 ms ago";
  snapshot.zoom = ZoomStand{512, mono_now() - 5s, mono_now() - 2s};
  head.put(snapshot);
  loop.step();
  EXPECT_TRUE(std::isnan(keeper.zoom)) << "told too long ago";
}

}  // namespace
}  // namespace ninedot
