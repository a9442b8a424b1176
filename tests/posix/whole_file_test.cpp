#include "drivers/posix/whole_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <future>
#include <string_view>
#include <thread>
#include <vector>

#include "base/startup_error.h"
#include "drivers/posix/output_file.h"

namespace {

/// Of each fsync: whether a folder was meant, and whether the finished file was there already.
struct Sync {
  bool is_folder, is_there;
  friend bool operator==(const Sync&, const Sync&) = default;
};
std::vector<Sync> syncs;
std::string finished_file;
int sync_error = 0;
bool has_proc = true;

}  // namespace

/// In libc's place.
extern "C" int fsync(int descriptor) {
  struct stat status {};
  ::fstat(descriptor, &status);
  syncs.push_back({S_ISDIR(status.st_mode), std::filesystem::exists(finished_file)});
  if (sync_error == 0) return static_cast<int>(::syscall(SYS_fsync, descriptor));
  errno = sync_error;
  return -1;
}

/// Likewise: without /proc a file that has no name can't be given one.
extern "C" int access(const char* path, int mode) {
  if (!has_proc && std::string_view(path).starts_with("/proc/")) return -1;
  return static_cast<int>(::syscall(SYS_faccessat, AT_FDCWD, path, mode));
}

namespace ninedot {
namespace {

using namespace std::chrono_literals;

namespace fs = std::filesystem;

class WholeFile : public testing::Test {
 protected:
  WholeFile() {
    std::string pattern = (fs::temp_directory_path() / "ninedot-test-XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr) std::abort();
    folder_ = pattern;
    finished_file = folder_ / "file";
    syncs.clear();
    sync_error = 0;
    has_proc = true;
  }
  ~WholeFile() override { fs::remove_all(folder_); }
  static std::span<const std::uint8_t> bytes(std::string_view text) {
    return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
  }
  static std::string text_of(const fs::path& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  /// Writes half a file and is killed.
  static void be_killed_writing(const std::string& path) {
    const pid_t child = ::fork();
    if (child == 0) {
      OutputFile file(path);
      file.write(std::string(100'000, 'x'));
      ::raise(SIGKILL);
    }
    int status = 0;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_TRUE(WIFSIGNALED(status));
  }
  std::size_t files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator{}));
  }
  fs::path folder_;
};

TEST_F(WholeFile, IsOnTheDiskBeforeItIsSeenAndItsNameAfterwards) {
  ASSERT_TRUE(write_whole_file(finished_file, bytes("new")));
  EXPECT_EQ(text_of(finished_file), "new");
  EXPECT_EQ(syncs, (std::vector<Sync>{{false, false}, {true, true}}));
  EXPECT_EQ(files(), 1U);
}

TEST_F(WholeFile, APictureDoesNotWaitForTheDisk) {
  ASSERT_TRUE(write_whole_file(finished_file, bytes("new"), Durability::kWhenConvenient));
  EXPECT_EQ(text_of(finished_file), "new");
  EXPECT_TRUE(syncs.empty());
}

TEST_F(WholeFile, KeepsTheOldOneWhereTheDiskFails) {
  ASSERT_TRUE(write_whole_file(finished_file, bytes("old")));
  sync_error = EIO;
  const Result<std::size_t> written = write_whole_file(finished_file, bytes("new"));
  ASSERT_FALSE(written);
  EXPECT_EQ(written.error().os_errno, EIO);
  EXPECT_EQ(text_of(finished_file), "old");
  EXPECT_EQ(files(), 1U) << "the temporary file is gone";
}

TEST_F(WholeFile, TouchesNobodyElsesFile) {
  std::ofstream(folder_ / "file.tmp") << "precious";
  {
    const Result<FileReplacement> first = FileReplacement::begin(finished_file);
    Result<FileReplacement> second = FileReplacement::begin(finished_file);
    ASSERT_TRUE(first && second);
    ASSERT_TRUE(second->write(bytes("second")));
    ASSERT_TRUE(second->commit(Durability::kWhenConvenient));
  }
  EXPECT_EQ(text_of(finished_file), "second");
  EXPECT_EQ(text_of(folder_ / "file.tmp"), "precious");
  EXPECT_EQ(files(), 2U);
}

TEST_F(WholeFile, WhoIsKilledLeavesNothingBehind) {
  if (!FileDescriptor(::open(folder_.c_str(), O_WRONLY | O_TMPFILE | O_CLOEXEC, 0644)))
    GTEST_SKIP() << "the temporary folder's file system has no files without a name";
  std::ofstream(finished_file) << "old";
  be_killed_writing(finished_file);
  EXPECT_EQ(text_of(finished_file), "old");
  EXPECT_EQ(files(), 1U);
}

TEST_F(WholeFile, WritesWhereFilesMustHaveANameFromTheStart) {
  has_proc = false;
  {
    Result<FileReplacement> abandoned = FileReplacement::begin(finished_file);
    ASSERT_TRUE(abandoned && abandoned->write(bytes("half")));
    EXPECT_EQ(files(), 1U);
  }
  EXPECT_EQ(files(), 0U);
  ASSERT_TRUE(write_whole_file(finished_file, bytes("new")));
  EXPECT_EQ(text_of(finished_file), "new");
  EXPECT_EQ(files(), 1U);
}

TEST_F(WholeFile, LeavesNothingBehindWhereItsPlaceWasTaken) {
  {
    Result<FileReplacement> file = FileReplacement::begin(finished_file);
    ASSERT_TRUE(file && file->write(bytes("new")));
    fs::create_directory(finished_file);
    const Result<std::size_t> committed = file->commit(Durability::kPowerCut);
    ASSERT_FALSE(committed);
    EXPECT_EQ(committed.error().os_errno, EISDIR);
  }
  EXPECT_EQ(files(), 1U);
}

TEST_F(WholeFile, ALinkStaysOne) {
  fs::create_symlink("target", folder_ / "link");
  std::ofstream(folder_ / "target") << "old";
  ASSERT_TRUE(write_whole_file(folder_ / "link", bytes("new")));
  EXPECT_TRUE(fs::is_symlink(folder_ / "link"));
  EXPECT_EQ(text_of(folder_ / "target"), "new");
  EXPECT_EQ(files(), 2U);
}

TEST_F(WholeFile, AFolderIsRefusedBeforeAnythingIsWritten) {
  const Result<FileReplacement> file = FileReplacement::begin(folder_);
  ASSERT_FALSE(file);
  EXPECT_EQ(file.error().os_errno, EISDIR);
  EXPECT_EQ(files(), 0U);
}

TEST_F(WholeFile, WritesDevicesDirectlyAndLeavesThemWhatTheyAre) {
  ASSERT_EQ(::mkfifo((folder_ / "fifo").c_str(), 0600), 0);
  const int reader = ::open((folder_ / "fifo").c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_TRUE(write_whole_file(folder_ / "fifo", bytes("new")));
  char text[8];
  EXPECT_EQ(::read(reader, text, sizeof text), 3);
  ::close(reader);
  EXPECT_TRUE(fs::is_fifo(folder_ / "fifo"));
  EXPECT_EQ(files(), 1U);
  EXPECT_TRUE(syncs.empty());
}

TEST_F(WholeFile, OutputInPiecesIsThereAtFinishAndNotBefore) {
  const std::string piece(40'000, 'x');
  {
    OutputFile abandoned(finished_file);
    for (int i = 0; i < 5; ++i) abandoned.write(piece);
  }
  EXPECT_EQ(files(), 0U);
  OutputFile file(finished_file);
  for (int i = 0; i < 5; ++i) file.write(piece);
  EXPECT_FALSE(fs::exists(finished_file));
  file.finish();
  EXPECT_EQ(fs::file_size(finished_file), 5 * piece.size());
  EXPECT_EQ(syncs, (std::vector<Sync>{{false, false}, {true, true}}));
}

TEST_F(WholeFile, OfOutputsTogetherNoneIsThereWhereOneFails) {
  std::ofstream(finished_file) << "old";
  {
    OutputFile first(finished_file), second("/dev/full");
    first.write("new");
    second.write("new");
    EXPECT_THROW(finish_together({&first, nullptr, &second}), StartupError);
  }
  EXPECT_EQ(text_of(finished_file), "old");
  OutputFile first(finished_file), second(folder_ / "other");
  first.write("new");
  second.write("new");
  syncs.clear();
  finish_together({&first, nullptr, &second});
  EXPECT_EQ(text_of(finished_file), "new");
  EXPECT_EQ(text_of(folder_ / "other"), "new");
  EXPECT_EQ(syncs.size(), 4U);
  EXPECT_FALSE(syncs[0].is_folder || syncs[1].is_folder) << "both are on the disk before one has its name";
  EXPECT_EQ(files(), 2U);
}

TEST_F(WholeFile, OutputSaysInOneLineWhatIsInTheWay) {
  for (const auto& [path, why] : {std::pair<std::string, std::string>{folder_ / "no/file", "No such file or directory"},
                                  {"/dev/full", "No space left on device"}}) {
    try {
      OutputFile file(path);
      file.write("text");
      file.finish();
      ADD_FAILURE() << path;
    } catch (const StartupError& error) {
      EXPECT_EQ(error.status, ExitStatus::kWorkFailed);
      EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
    }
  }
}

TEST(ReadWholeFile, TellsAFileThatFitsExactlyFromOneThatIsTooLong) {
  const std::string path = (fs::temp_directory_path() / ("ninedot-read-" + std::to_string(::getpid()))).string();
  std::ofstream(path) << "seventeen letters";
  std::vector<std::uint8_t> buffer(17);
  const auto fits = read_whole_file(path.c_str(), buffer);
  ASSERT_TRUE(fits);
  EXPECT_EQ(*fits, 17U);
  EXPECT_EQ(std::string(buffer.begin(), buffer.end()), "seventeen letters");
  const auto too_long = read_whole_file(path.c_str(), std::span(buffer).first(16));
  ASSERT_FALSE(too_long);
  EXPECT_EQ(too_long.error().os_errno, EFBIG);
  fs::remove(path);
  const auto absent = read_whole_file(path.c_str(), buffer);
  ASSERT_FALSE(absent);
  EXPECT_EQ(absent.error().os_errno, ENOENT);
}

/// A named pipe, and what reading it gave.
class ReadFifo : public testing::Test {
 protected:
  ReadFifo() : path_(fs::temp_directory_path() / ("ninedot-fifo-" + std::to_string(::getpid()))) {
    EXPECT_EQ(::mkfifo(path_.c_str(), 0600), 0);
    std::signal(SIGPIPE, SIG_IGN);  // of a writer whose reader gave up
  }
  ~ReadFifo() override { fs::remove(path_); }

  std::string read() {
    auto reading = std::async(std::launch::async, [&] {
      std::vector<std::uint8_t> buffer(100'000);
      const auto size = read_whole_file(path_.c_str(), buffer);
      return size ? std::string(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(*size))
                  : size.error().text;
    });
    if (reading.wait_for(20s) == std::future_status::ready) return reading.get();
    const FileDescriptor let_go(::open(path_.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC));
    return "waits without end";
  }

  /// Waits for the writer, which waits for somebody who takes what was not read.
  void drain(std::future<void> writing) const {
    const FileDescriptor reader(::open(path_.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
    std::array<char, 4096> rest;
    while (::read(reader.get(), rest.data(), rest.size()) > 0 || writing.wait_for(1ms) != std::future_status::ready) {
    }
  }

  fs::path path_;
};

TEST_F(ReadFifo, ThatNobodyWritesToIsRefused) { EXPECT_EQ(read(), "is a pipe that nobody writes to"); }

TEST_F(ReadFifo, WhoseWriterTakesItsTimeIsReadToItsEnd) {
  const std::string half(70'000, 'x');  // more than a pipe holds
  auto writer = std::async(std::launch::async, [&] {
    std::this_thread::sleep_for(100ms);  // it comes later than the reader
    const FileDescriptor file(::open(path_.c_str(), O_WRONLY | O_CLOEXEC));
    for (const std::string& text : {std::string("first "), half}) {
      std::this_thread::sleep_for(1500ms);
      EXPECT_EQ(::write(file.get(), text.data(), text.size()), static_cast<ssize_t>(text.size()));
    }
  });
  EXPECT_EQ(read(), "first " + half);
  drain(std::move(writer));
}

TEST_F(ReadFifo, WhoseWriterHasNothingToSayIsAnEmptyFile) {
  auto writer =
      std::async(std::launch::async, [&] { const FileDescriptor file(::open(path_.c_str(), O_WRONLY | O_CLOEXEC)); });
  EXPECT_EQ(read(), "");
  drain(std::move(writer));
}

TEST(ReadPipe, OfAShellsSubstitutionIsReadAsAFile) {
  std::array<int, 2> ends{};
  ASSERT_EQ(::pipe(ends.data()), 0);
  const FileDescriptor reader(ends[0]);
  {
    const FileDescriptor writer(ends[1]);
    ASSERT_EQ(::write(writer.get(), "text", 4), 4);
  }
  std::vector<std::uint8_t> buffer(10);
  const auto size = read_whole_file(("/dev/fd/" + std::to_string(reader.get())).c_str(), buffer);
  ASSERT_TRUE(size) << size.error().text;
  EXPECT_EQ(std::string(buffer.begin(), buffer.begin() + static_cast<std::ptrdiff_t>(*size)), "text");
}

}  // namespace
}  // namespace ninedot
