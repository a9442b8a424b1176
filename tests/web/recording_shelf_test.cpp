#include "programs/web/recording_shelf.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "base/startup_error.h"
#include "drivers/recording/recording_index.h"
#include "programs/web/tap_recording.h"
#include "tests/web/recording_frames.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

const std::string kName = "20261123-121415-asked";

void record(const std::string& folder, int frames, bool ends) {
  MadeUpService service;
  TapRecording recording(folder, *service.next().header);
  for (int i = 0; i < frames; ++i) ASSERT_TRUE(recording.add(service.next().copy));
  if (ends) recording.end("stopped by hand");
}

TEST(RecordingName, TellsWhenAndWhy) {
  const std::chrono::system_clock::time_point begun(std::chrono::seconds(1795436055));
  EXPECT_EQ(recording_name(begun, RecordingCause::kAsked), "20261123-121415-asked");
  EXPECT_EQ(recording_name(begun, RecordingCause::kLoss), "20261123-121415-loss");
  EXPECT_EQ(cause_of("20261123-121415-loss"), RecordingCause::kLoss);
}

TEST(RecordingName, IsNothingThatSomebodyElseMade) {
  EXPECT_TRUE(is_recording_name(kName));
  for (const std::string& name :
       {std::string(), std::string(".."), kName + "x", "x" + kName, kName + std::string(1, '\0'), kName + "/..",
        std::string("20261123-12141x-asked"), std::string("20261123-121415-other"), std::string("20261123-121415-"),
        std::string("20261123-121415"), std::string("../61123-121415-asked"), std::string(5000, 'a')})
    EXPECT_FALSE(is_recording_name(name)) << name;
}

TEST(RecordingPath, LeadsToWhatARecordingHasAndNowhereElse) {
  EXPECT_EQ(parse_recording_path(kName + "/frames/000012.png")->file, "frames/000012.png");
  EXPECT_EQ(parse_recording_path(kName + "/reports/1000012.json")->name, kName);
  EXPECT_EQ(parse_recording_path(kName + "/download")->file, "");
  for (const std::string& file :
       {std::string(), std::string(".."), std::string("frames"), std::string("frames/"), std::string("frames/.png"),
        std::string("frames/00012.png"), std::string("frames/0000000012.png"), std::string("frames/../../x.png"),
        std::string("frames/00001a.png"), std::string("frames/000012.json"), std::string("reports/000012.png"),
        std::string("ended.txt"), std::string("frames.csv/"), std::string("download/x"), std::string("/frames.csv")})
    EXPECT_FALSE(parse_recording_path(kName + "/" + file)) << file;
  for (const std::string& path : {kName, std::string("../frames.csv"), std::string("/frames.csv"), std::string()})
    EXPECT_FALSE(parse_recording_path(path)) << path;
}

TEST(RecordingShelf, FindsWhatWasRecordedBeforeItsStart) {
  const MemoryFolder folder;
  record(folder.path() + "/" + kName, 4, true);
  fs::create_directory(folder.path() + "/lost+found");
  const RecordingShelf shelf(folder.path());
  ASSERT_EQ(shelf.entries().size(), 1U);
  EXPECT_EQ(shelf.entries()[0].frames, 4U);
  EXPECT_EQ(shelf.entries()[0].duration, std::chrono::milliseconds(300));
  EXPECT_EQ(shelf.entries()[0].ended, "stopped by hand");
  EXPECT_GT(shelf.bytes(), 4000U);
  EXPECT_TRUE(fs::exists(folder.path() + "/lost+found"));
}

TEST(RecordingShelf, MendsWhatACrashLeftAndSaysSo) {
  const MemoryFolder folder;
  const std::string made = folder.path() + "/" + kName;
  record(made, 3, false);
  // As they lie there when the program dies between two of its steps, or the power goes.
  std::ofstream(made + "/frames/000003.png") << "no row tells of it";
  std::ofstream(made + "/frames/000004.png.abc.tmp") << "half";
  std::ofstream(made + "/frames/000001.tmp") << "half";
  std::ofstream(made + "/frames.csv", std::ios::app) << "3,30000";
  EXPECT_THROW(read_recording_index(made), StartupError) << "what replay would say";
  const RecordingShelf shelf(folder.path());
  ASSERT_EQ(shelf.entries().size(), 1U);
  EXPECT_EQ(shelf.entries()[0].frames, 3U);
  EXPECT_NE(shelf.entries()[0].ended.find("cut off"), std::string::npos);
  EXPECT_EQ(read_recording_index(made).frames.size(), 3U);
  EXPECT_EQ(std::distance(fs::directory_iterator(made + "/frames"), fs::directory_iterator()), 3);
}

TEST(RecordingShelf, MendsWhatAKilledProcessLeft) {
  const MemoryFolder folder;
  const std::string made = folder.path() + "/" + kName;
  const pid_t child = ::fork();
  if (child == 0) {
    MadeUpService service;
    TapRecording recording(made, *service.next().header);
    for (;;) static_cast<void>(recording.add(service.next().copy));
  }
  while (!fs::exists(made + "/frames/000020.png")) ::usleep(1000);
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  const RecordingShelf shelf(folder.path());
  ASSERT_EQ(shelf.entries().size(), 1U);
  EXPECT_GE(shelf.entries()[0].frames, 20U);
  EXPECT_EQ(read_recording_index(made).frames.size(), shelf.entries()[0].frames);
}

TEST(RecordingShelf, TakesAwayWhatNothingWasRecordedIn) {
  const MemoryFolder folder;
  fs::create_directories(folder.path() + "/" + kName + "/frames");
  std::ofstream(folder.path() + "/" + kName + "/frames.csv") << "frame,timestamp_ns,pan_deg,tilt_deg\n";
  fs::create_directories(folder.path() + "/.doomed-20261123-121415-loss/frames");
  const RecordingShelf shelf(folder.path());
  EXPECT_TRUE(shelf.entries().empty());
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

TEST(RecordingShelf, IsForOneProcessAtATime) {
  const MemoryFolder folder;
  const RecordingShelf shelf(folder.path());
  try {
    const RecordingShelf other(folder.path());
    FAIL() << "two would take each other's recordings for what a crash left";
  } catch (const StartupError& error) {
    EXPECT_NE(std::string(error.what()).find("another ninedot-web uses this folder"), std::string::npos);
  }
}

TEST(RecordingShelf, SaysWhatToDoAboutAFolderThatIsNone) {
  const MemoryFolder folder;
  std::ofstream(folder.path() + "/file") << "x";
  EXPECT_THROW(RecordingShelf(folder.path() + "/file/deeper"), StartupError);
}

TEST(RecordingShelf, GivesNoNameTwice) {
  const MemoryFolder folder;
  const RecordingShelf shelf(folder.path());
  const std::string first = shelf.free_name(RecordingCause::kAsked);
  fs::create_directory(shelf.path_of(first));
  EXPECT_NE(shelf.free_name(RecordingCause::kAsked), first);
}

TEST(RecordingShelf, GivesANameToAMachineWithoutAClockThatHasBegunOften) {
  const MemoryFolder folder;
  const RecordingShelf shelf(folder.path());
  const auto now = std::chrono::system_clock::now();
  for (int second = -2; second < 100; ++second)
    fs::create_directory(shelf.path_of(recording_name(now + std::chrono::seconds(second), RecordingCause::kLoss)));
  const std::string name = shelf.free_name(RecordingCause::kLoss);
  EXPECT_TRUE(is_recording_name(name)) << name;
  EXPECT_FALSE(fs::exists(shelf.path_of(name))) << name;
}

TEST(RecordingShelf, TakesAwayWhatIsOldestAlsoAfterTheClockWasPutBack) {
  const MemoryFolder folder;
  const std::string before = "20351123-121415-loss", after = "20260101-000000-loss";
  record(folder.path() + "/" + before, 1, true);
  RecordingShelf shelf(folder.path());
  record(folder.path() + "/" + after, 1, true);
  ShelfEntry made;
  made.name = after;
  shelf.add(made);
  EXPECT_TRUE(shelf.remove_oldest_loss());
  ASSERT_EQ(shelf.entries().size(), 1U);
  EXPECT_EQ(shelf.entries()[0].name, after);
}

TEST(RecordingShelf, DeletesOfTheListAndOfTheDisk) {
  const MemoryFolder folder;
  record(folder.path() + "/" + kName, 2, true);
  RecordingShelf shelf(folder.path());
  EXPECT_FALSE(shelf.remove("20261123-121416-asked"));
  EXPECT_TRUE(shelf.remove(kName));
  EXPECT_TRUE(shelf.entries().empty());
  EXPECT_TRUE(fs::is_empty(folder.path()));
}

}  // namespace
}  // namespace ninedot
