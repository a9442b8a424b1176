#include "programs/web/recorder.h"

#include <gtest/gtest.h>

#include <thread>

#include "drivers/tap/tap_writer.h"
#include "programs/web/recorder_json.h"
#include "tests/web/recording_frames.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

RecorderOptions options_in(const std::string& folder) {
  RecorderOptions options;
  options.tap_path = folder + "/no-tap";
  options.folder = folder + "/recordings";
  options.may_ask = true;
  options.rules.most_bytes = 1'000'000;
  options.rules.longest = 60s;
  return options;
}

TEST(Recorder, UnderstandsWhatItIsAskedToTheLastCharacter) {
  const MemoryFolder folder;
  Recorder recorder(options_in(folder.path()));
  for (const std::string& text :
       {std::string(), std::string("start "), std::string("Start"), std::string("start\n"), std::string("delete"),
        std::string("delete "), std::string("delete .."), std::string("delete ../../etc"),
        std::string("delete 20261123-121415-asked/"), "delete 20261123-121415-asked" + std::string(1, '\0')})
    EXPECT_EQ(recorder.reply_to(text).status, 400U) << text;
  EXPECT_EQ(recorder.reply_to("delete 20261123-121415-asked").status, 404U);
  EXPECT_EQ(recorder.reply_to("stop").status, 409U);
}

TEST(Recorder, SaysWhyNoFrameComes) {
  const MemoryFolder folder;
  Recorder recorder(options_in(folder.path()));
  EXPECT_EQ(recorder.reply_to("start").status, 200U);
  EXPECT_NE(recorder.state_json().find("\"phase\":\"starting\""), std::string::npos);
  EXPECT_EQ(recorder.reply_to("start").status, 409U);
  for (int i = 0; i < 100 && recorder.state_json().find("starting") != std::string::npos; ++i)
    std::this_thread::sleep_for(100ms);
  EXPECT_NE(recorder.state_json().find("is ninedotd running"), std::string::npos) << recorder.state_json();
}

TEST(Recorder, TellsAtOnceThatARecordingHasEndedByItself) {
  const MemoryFolder folder;
  RecorderOptions options = options_in(folder.path());
  options.rules.longest = 0s;  // over with its first frame: sooner after its start than pages are told of changes
  TapHeader header;
  header.width_px = 32, header.height_px = 16, header.rate_hz = 100;
  TapWriter service(options.tap_path, header);
  Recorder recorder(options);
  const std::vector<std::uint8_t> pixels(32 * 16);
  TapFrame frame;
  const auto is_over = [&] { return recorder.state_json().find("\"phase\":\"starting\"") == std::string::npos; };
  for (int i = 0; i < 2; ++i) {  // before the first one nothing was told, and what is first is told at once
    EXPECT_EQ(recorder.reply_to("start").status, 200U);
    std::this_thread::sleep_for(50ms);                        // the tap is opened
    service.publish(frame, {pixels.data(), 32, 16, 32}, {});  // one alone: no later one wakes the recorder
    for (const MonoTime until = mono_now() + 10s; !is_over() && mono_now() < until;) std::this_thread::sleep_for(10ms);
    EXPECT_TRUE(is_over()) << recorder.state_json();
  }
}

TEST(Recorder, GoesOnWithoutAFolderThatItCanUse) {
  const MemoryFolder folder;
  std::ofstream(folder.path() + "/recordings") << "a file";
  Recorder recorder(options_in(folder.path()));
  EXPECT_EQ(recorder.reply_to("start").status, 409U);
  EXPECT_NE(recorder.state_json().find("no recordings: the folder can't be made"), std::string::npos)
      << recorder.state_json();
}

TEST(Recorder, RecordsNothingWhereNoFolderIsNamed) {
  const RecorderOptions options = recorder_options(Config{}, true);
  EXPECT_NE(options.why_not.find("`recordings` of [web]"), std::string::npos);
  EXPECT_EQ(options.rules.loss.before, 0ns);
}

TEST(FrameQueue, GivesFramesInTheirOrderAndTakesNoneWhenItIsFull) {
  FrameQueue queue;
  MadeUpService service;
  QueuedFrame frame = service.next();
  EXPECT_FALSE(queue.push(frame)) << "no room was made";
  queue.reserve(FrameQueue::kMost_bytes / 3);
  for (int i = 0; i < 3; ++i) {
    frame = service.next();
    EXPECT_TRUE(queue.push(frame));
  }
  frame = service.next();
  EXPECT_FALSE(queue.push(frame));
  EXPECT_EQ(frame.copy.publication, 5U) << "still the caller's";
  for (std::uint64_t publication = 2; publication <= 4; ++publication) {
    ASSERT_TRUE(queue.pop(frame, mono_now()));
    EXPECT_EQ(frame.copy.publication, publication);
  }
  EXPECT_FALSE(queue.pop(frame, mono_now()));
}

TEST(FrameQueue, HoldsTwoHoweverLargeAndSixteenHoweverSmall) {
  MadeUpService service;
  for (const auto& [bytes, most] : {std::pair<std::size_t, int>{FrameQueue::kMost_bytes * 2, 2}, {1, 16}}) {
    FrameQueue queue;
    queue.reserve(bytes);
    int taken = 0;
    for (QueuedFrame frame = service.next(); queue.push(frame); frame = service.next()) ++taken;
    EXPECT_EQ(taken, most);
  }
}

}  // namespace
}  // namespace ninedot
