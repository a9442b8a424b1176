#include "programs/web/recording_desk.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <csignal>

#include "base/startup_error.h"
#include "drivers/recording/recording_index.h"
#include "tests/web/recording_frames.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

// Of write(2) as it is on a disk with room for so many bytes more.
std::int64_t room_bytes = 0;
ssize_t write_while_there_is_room(int descriptor, const void* bytes, std::size_t count) {
  if (static_cast<std::int64_t>(count) > room_bytes) {
    errno = ENOSPC;
    return -1;
  }
  room_bytes -= static_cast<std::int64_t>(count);
  return ::write(descriptor, bytes, count);
}

class RecordingDeskTest : public testing::Test {
 protected:
  RecordingDesk& open(RecordingRules rules, WriteFunction write_bytes = write_to_disk) {
    desk_ = std::make_unique<RecordingDesk>(
        rules, shelf_, [this](const std::string& line) { log_ += line + "\n"; }, write_bytes);
    return *desk_;
  }
  static RecordingRules rules(std::chrono::nanoseconds before = {}) {
    RecordingRules rules;
    rules.most_bytes = 10'000'000;
    rules.longest = 60s;
    rules.loss.before = before;
    rules.most_losses = 3;
    return rules;
  }
  void take(int frames, bool is_valid = true) {
    for (int i = 0; i < frames; ++i) {
      QueuedFrame frame = service_.next(is_valid);
      desk_->take(frame, service_.now());
      while (desk_->save_one()) {
      }
    }
  }
  const ShelfEntry& only() const {
    static const ShelfEntry kNone;
    EXPECT_EQ(shelf_.entries().size(), 1U);
    return shelf_.entries().empty() ? kNone : shelf_.entries().front();
  }

  MemoryFolder folder_;
  RecordingShelf shelf_{folder_.path()};
  MadeUpService service_;
  std::unique_ptr<RecordingDesk> desk_;
  std::string log_;
};

TEST_F(RecordingDeskTest, WantsNothingAndWritesNothingWhileNobodyAsks) {
  RecordingDesk& desk = open(rules());
  EXPECT_FALSE(desk.wants_frames());
  take(20);
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(RecordingDeskTest, RecordsFromTheNextFrameUntilItIsStopped) {
  RecordingDesk& desk = open(rules());
  desk.start(service_.now());
  EXPECT_TRUE(desk.wants_frames());
  take(5);
  service_.skip(2);
  take(3);
  desk.stop("stopped by hand");
  EXPECT_FALSE(desk.wants_frames());
  take(4);
  EXPECT_EQ(only().frames, 8U);
  EXPECT_EQ(only().missed, 2U);
  EXPECT_EQ(only().duration, 900ms);
  EXPECT_EQ(only().ended, "stopped by hand");
  const RecordingIndex index = read_recording_index(shelf_.path_of(only().name));
  ASSERT_EQ(index.frames.size(), 8U);
  EXPECT_EQ(index.frames[5].number, 7U) << "the two that did not come";
  const std::string report = text_of_file(shelf_.path_of(only().name) + "/reports/000007.json");
  EXPECT_NE(report.find("\"number\":8,"), std::string::npos) << "the service's own number: " << report;
  EXPECT_NE(text_of_file(shelf_.path_of(only().name) + "/camera.json").find("\"width\":32"), std::string::npos);
}

TEST_F(RecordingDeskTest, CountsEveryByteThatItTakes) {
  RecordingDesk& desk = open(rules());
  desk.start(service_.now());
  take(6);
  desk.stop("stopped by hand");
  std::uint64_t bytes = 0;
  for (const auto& place : std::filesystem::recursive_directory_iterator(shelf_.path_of(only().name)))
    if (place.is_regular_file() && place.path().filename() != "frames.csv" && place.path().filename() != "ended.txt" &&
        place.path().filename() != "camera.yaml")
      bytes += place.file_size();
  EXPECT_EQ(only().bytes, bytes) << "but for what does not grow with its frames";
}

TEST_F(RecordingDeskTest, EndsByItselfAtTheLongest) {
  RecordingRules short_ones = rules();
  short_ones.longest = 1s;
  open(short_ones).start(service_.now());
  take(30);
  EXPECT_EQ(only().frames, 11U);
  EXPECT_NE(only().ended.find("`recording_s` of [web], are over"), std::string::npos) << only().ended;
  EXPECT_NE(desk_->state().note.find("ended by itself"), std::string::npos);
  EXPECT_FALSE(desk_->wants_frames());
}

TEST_F(RecordingDeskTest, NeverTakesMoreThanItsRoom) {
  RecordingRules small = rules();
  small.most_bytes = 60'000;
  open(small).start(service_.now());
  take(200);
  EXPECT_LE(shelf_.bytes(), 60'000U);
  EXPECT_GT(shelf_.bytes(), 50'000U);
  EXPECT_NE(only().ended.find("are full: delete recordings"), std::string::npos) << only().ended;
  desk_->start(service_.now());
  take(1);
  EXPECT_EQ(shelf_.entries().size(), 1U) << "and not one byte more";
  desk_->remove(only().name);
  desk_->start(service_.now());
  take(1);
  EXPECT_TRUE(desk_->state().running.has_value());
}

TEST_F(RecordingDeskTest, OnAFullDiskLosesThatFrameAlone) {
  room_bytes = 30'000;
  open(rules(), &write_while_there_is_room).start(service_.now());
  take(100);
  EXPECT_NE(only().ended.find("the disk is full"), std::string::npos) << only().ended;
  EXPECT_NE(log_.find("the disk is full"), std::string::npos);
  EXPECT_EQ(std::count(log_.begin(), log_.end(), '\n'), 1) << log_;
  const RecordingIndex index = read_recording_index(shelf_.path_of(only().name));
  EXPECT_EQ(index.frames.size(), only().frames);
  EXPECT_GT(index.frames.size(), 3U);
}

// The file system's own refusal, through every layer: no file may grow beyond 300 bytes.
TEST_F(RecordingDeskTest, EndsWhereTheSystemRefusesToWrite) {
  open(rules()).start(service_.now());
  take(3);
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  const rlimit small{300, before.rlim_max};
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
  take(3);
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
  EXPECT_FALSE(desk_->wants_frames());
  EXPECT_EQ(only().frames, read_recording_index(shelf_.path_of(only().name)).frames.size());
  EXPECT_NE(only().ended.find("File too large"), std::string::npos) << only().ended;
}

TEST_F(RecordingDeskTest, EndsWhereNoFrameComes) {
  RecordingDesk& desk = open(rules());
  desk.start(service_.now());
  desk.wait(service_.now() + 2s, "");
  EXPECT_TRUE(desk.wants_frames());
  desk.wait(service_.now() + 3s, "the service behind this tap has ended: start ninedotd");
  EXPECT_FALSE(desk.wants_frames());
  EXPECT_EQ(desk.state().note, "Nothing was recorded: the service behind this tap has ended: start ninedotd");
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST_F(RecordingDeskTest, OfAnotherServiceIsAnotherRecording) {
  open(rules()).start(service_.now());
  take(3);
  QueuedFrame other = MadeUpService().next();
  desk_->take(other, service_.now());
  EXPECT_EQ(only().ended, "the service was started again");
  EXPECT_EQ(only().frames, 3U);
}

TEST_F(RecordingDeskTest, KeepsWhatPrecededALossAndASecondAfterIt) {
  open(rules(2s));
  take(50);
  EXPECT_TRUE(shelf_.entries().empty());
  take(30, false);
  EXPECT_EQ(cause_of(only().name), RecordingCause::kLoss);
  // The last valid frame is the 50th, at 5 s: from 3 s to 6 s.
  const RecordingIndex index = read_recording_index(shelf_.path_of(only().name));
  EXPECT_EQ(index.frames.size(), 31U);
  EXPECT_EQ(index.frames.front().recorded_at, 3s);
  EXPECT_EQ(index.frames.back().recorded_at, 6s);
}

TEST_F(RecordingDeskTest, KeepsTheNewestLossesAlone) {
  RecordingRules often = rules(1s);
  often.loss.rest = 0s;
  open(often);
  std::vector<std::string> names;
  for (int i = 0; i < 5; ++i) {
    take(20);
    take(15, false);
    ASSERT_FALSE(shelf_.entries().empty());
    names.push_back(shelf_.entries().back().name);
  }
  ASSERT_EQ(shelf_.entries().size(), 3U);
  EXPECT_EQ(shelf_.entries().front().name, names[2]);
  EXPECT_FALSE(std::filesystem::exists(shelf_.path_of(names[1])));
}

TEST_F(RecordingDeskTest, MakesRoomForALossByOlderLossesAndNotByWhatWasAskedFor) {
  RecordingRules small = rules(1s);
  small.loss.rest = 0s;
  small.most_losses = 10;
  small.most_bytes = 80'000;
  open(small).start(service_.now());
  take(10);
  desk_->stop("stopped by hand");
  const std::string asked = shelf_.entries().front().name;
  for (int i = 0; i < 6; ++i) take(20), take(15, false);
  EXPECT_LE(shelf_.bytes(), 80'000U);
  EXPECT_EQ(shelf_.entries().front().name, asked);
  EXPECT_GE(shelf_.losses(), 1U);
  EXPECT_LT(shelf_.losses(), 6U);
}

TEST_F(RecordingDeskTest, RecordsWhileALossIsSaved) {
  open(rules(2s)).start(service_.now());
  for (int i = 0; i < 60; ++i) {
    QueuedFrame frame = service_.next(i < 30);
    desk_->take(frame, service_.now());
    desk_->save_one();
  }
  desk_->close();
  ASSERT_EQ(shelf_.entries().size(), 2U);
  EXPECT_EQ(shelf_.entries()[0].frames + shelf_.entries()[1].frames, 60U + 21U)
      << "of the ring's 31 those of 4 s to 6 s: then the program ended";
  EXPECT_EQ(shelf_.entries()[0].missed, 0U);
}

}  // namespace
}  // namespace ninedot
