#include "programs/commands/config_change.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "base/startup_error.h"
#include "programs/commands/candidate.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;

int writes_left = 0;

/// A disk that is full after so many writes.
ssize_t write_until_full(int descriptor, const void* bytes, std::size_t count) {
  if (writes_left-- > 0) return ::write(descriptor, bytes, count);
  errno = ENOSPC;
  return -1;
}

class ConfigChangeTest : public testing::Test {
 protected:
  ConfigChangeTest() {
    std::string pattern = (fs::temp_directory_path() / "ninedot-test-XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr) std::abort();
    folder_ = pattern;
    file_ = (folder_ / "ninedot.toml").string();
    write(file_, "old");
  }
  ~ConfigChangeTest() override { fs::remove_all(folder_); }

  static void write(const fs::path& file, std::string_view text) { std::ofstream(file) << text; }
  static std::string text_of(const fs::path& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  std::vector<std::string> names() const {
    std::vector<std::string> found;
    for (const auto& entry : fs::directory_iterator(folder_)) found.push_back(entry.path().filename().string());
    std::sort(found.begin(), found.end());
    return found;
  }
  static std::string refusal_of(const std::function<void()>& step, ExitStatus status) {
    try {
      step();
    } catch (const StartupError& error) {
      EXPECT_EQ(error.status, status) << error.what();
      return error.what();
    }
    ADD_FAILURE() << "was not refused";
    return {};
  }
  fs::path folder_;
  std::string file_;
};

using Names = std::vector<std::string>;

TEST_F(ConfigChangeTest, KeepsTheOldOneUntilTheNewOneIsKnownToRun) {
  ConfigChange change(file_);
  EXPECT_EQ(change.text(), "old");
  change.put("new");
  EXPECT_EQ(text_of(file_), "new");
  EXPECT_EQ(text_of(change.last_good_path()), "old");
  change.confirm();
  EXPECT_EQ(text_of(file_), "new");
  EXPECT_EQ(text_of(change.before_path()), "old");
  EXPECT_EQ(names(), (Names{"ninedot.toml", "ninedot.toml.before"}));
}

TEST_F(ConfigChangeTest, PutsTheOldOneBackAndLeavesTheOneBeforeItAlone) {
  write(file_ + ".before", "older");
  ConfigChange change(file_);
  change.put("new");
  change.put_back();
  EXPECT_EQ(text_of(file_), "old");
  EXPECT_EQ(text_of(change.before_path()), "older");
  EXPECT_EQ(names(), (Names{"ninedot.toml", "ninedot.toml.before"}));
}

TEST_F(ConfigChangeTest, KnowsThatAnEarlierOneWasCutShortAndGoesBackToWhatRanBeforeIt) {
  ConfigChange(file_).put("cut short");
  {
    ConfigChange change(file_);
    EXPECT_TRUE(change.was_cut_short());
    EXPECT_EQ(change.last_good(), "old");
    change.put("another");
    EXPECT_EQ(text_of(change.last_good_path()), "old") << "what was never seen to run is nothing to go back to";
    change.put_back();
    EXPECT_EQ(text_of(file_), "old");
  }
  EXPECT_FALSE(ConfigChange(file_).was_cut_short());
}

TEST_F(ConfigChangeTest, LeavesEverythingAsItWasOnADiskThatIsFull) {
  for (const int writes : {0, 1}) {
    writes_left = writes;
    ConfigChange change(file_, write_until_full);
    const std::string line = refusal_of([&] { change.put("new"); }, ExitStatus::kWorkFailed);
    EXPECT_NE(line.find("No space left"), std::string::npos) << line;
    EXPECT_EQ(text_of(file_), "old");
    EXPECT_EQ(names(), Names{"ninedot.toml"});
  }
}

TEST_F(ConfigChangeTest, KeepsOwnerAndModeWhateverTheUmask) {
  ::chmod(file_.c_str(), 0640);
  const bool is_given_away = ::geteuid() != 0 || ::chown(file_.c_str(), 1234, 2345) == 0;
  ASSERT_TRUE(is_given_away);
  struct stat before {};
  ::stat(file_.c_str(), &before);
  const mode_t mask = ::umask(0077);
  ConfigChange change(file_);
  change.put("new");
  ::umask(mask);
  for (const std::string& path : {file_, change.last_good_path()}) {
    struct stat after {};
    ASSERT_EQ(::stat(path.c_str(), &after), 0);
    EXPECT_EQ(after.st_mode & 07777U, 0640U) << path;
    EXPECT_EQ(after.st_uid, before.st_uid) << path;
    EXPECT_EQ(after.st_gid, before.st_gid) << path;
  }
}

TEST_F(ConfigChangeTest, OfALinkReplacesWhatItLeadsTo) {
  fs::create_directory(folder_ / "elsewhere");
  write(folder_ / "elsewhere" / "real.toml", "old");
  fs::remove(file_);
  fs::create_symlink("elsewhere/real.toml", file_);
  ConfigChange change(file_);
  change.put("new");
  change.confirm();
  EXPECT_TRUE(fs::is_symlink(file_));
  EXPECT_EQ(text_of(folder_ / "elsewhere" / "real.toml"), "new");
  EXPECT_EQ(text_of(folder_ / "elsewhere" / "real.toml.before"), "old");
}

TEST_F(ConfigChangeTest, IsForOneAtATime) {
  {
    const ApplyLock lock(file_);
    const std::string line = refusal_of([&] { ApplyLock second(file_); }, ExitStatus::kWorkFailed);
    EXPECT_NE(line.find("another apply is under way"), std::string::npos) << line;
  }
  const ApplyLock again(file_);
}

TEST_F(ConfigChangeTest, RefusesWhatIsNoFile) {
  refusal_of([&] { ConfigChange(folder_.string()); }, ExitStatus::kWrongUsage);
  refusal_of([&] { ConfigChange(file_ + ".none"); }, ExitStatus::kWrongUsage);
  const std::string fifo = file_ + ".fifo";
  ASSERT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  refusal_of([&] { ConfigChange{fifo}; }, ExitStatus::kWrongUsage);
  write(file_, std::string(kMaxApplied_bytes + 1, '#'));
  refusal_of([&] { ConfigChange{file_}; }, ExitStatus::kWrongUsage);
}

/// What read_request makes of bytes after which the connection ends.
std::string request(std::string_view bytes) {
  std::array<int, 2> ends{};
  if (::pipe(ends.data()) != 0 || ::fcntl(ends[1], F_SETPIPE_SZ, 1 << 20) < 0) std::abort();
  EXPECT_EQ(::write(ends[1], bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  ::close(ends[1]);
  const FileDescriptor input(ends[0]);
  const Candidate candidate = read_request(input.get());
  return (candidate.kind == CandidateKind::kCalibration ? "calibration: " : "") + candidate.text;
}

TEST_F(ConfigChangeTest, TakesARequestThatIsWholeAndNoOther) {
  EXPECT_EQ(request("apply 3\nnew"), "new");
  EXPECT_EQ(request("calibration 3\nnew"), "calibration: new");
  const std::string most(kMaxApplied_bytes, '#');
  EXPECT_EQ(request("apply 262144\n" + most), most);
  for (const std::string bytes :
       {"", "\n", "apply", "apply \n", "apply 0\n", "apply 4\nnew", "apply 2\nnew", "apply -3\nnew", "apply 3 \nnew",
        "apply 262145\n", "calibration 4\nnew", "calibration 262145\n", "calibration\nnew", "use 3\nnew",
        "apply 99999999999999999999999\nnew", "APPLY 3\nnew", "GET / HTTP/1.1\r\n\r\n"})
    EXPECT_FALSE(refusal_of([&] { request(bytes); }, ExitStatus::kWrongUsage).empty()) << bytes;
  refusal_of([&] { request(std::string(100000, 'x')); }, ExitStatus::kWrongUsage);
}

TEST_F(ConfigChangeTest, TakesNoCandidateThatIsEmptyHugeOrNoFile) {
  EXPECT_EQ(read_candidate(file_), "old");
  write(folder_ / "empty", "");
  refusal_of([&] { read_candidate((folder_ / "empty").string()); }, ExitStatus::kWrongUsage);
  refusal_of([&] { read_candidate(folder_.string()); }, ExitStatus::kWrongUsage);
  refusal_of([&] { read_candidate("/dev/zero"); }, ExitStatus::kWrongUsage);
}

}  // namespace
}  // namespace ninedot
