#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <thread>
#include <vector>

#include "base/mono_time.h"
#include "base/startup_error.h"
#include "drivers/tap/tap_reader.h"
#include "drivers/tap/tap_writer.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/sanitizers.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

/// A folder of its own in memory.
class Tap : public testing::Test {
 protected:
  Tap() {
    std::string name = "/dev/shm/ninedot-tap-test-XXXXXX";
    folder_ = ::mkdtemp(name.data());
    header_.width_px = kWidth;
    header_.height_px = kHeight;
  }
  ~Tap() override { std::filesystem::remove_all(folder_); }

  std::string path() const { return folder_ + "/tap"; }
  /// What constructing `Thing` from the path is refused with.
  std::string refusal_of_reader() const {
    try {
      const TapReader reader(path());
    } catch (const StartupError& error) {
      EXPECT_EQ(error.status, ExitStatus::kWorkFailed);
      return error.what();
    }
    return "";
  }

  static constexpr int kWidth = 64, kHeight = 48;
  std::string folder_;
  TapHeader header_;
};

struct Picture {
  explicit Picture(int stride = 64) : stride_bytes(stride), bytes(static_cast<std::size_t>(stride) * 48) {
    std::iota(bytes.begin(), bytes.end(), std::uint8_t{1});
  }
  ImageView view() const { return {bytes.data(), 64, 48, stride_bytes}; }
  std::ptrdiff_t stride_bytes;
  std::vector<std::uint8_t> bytes;
};

void expect_same(const ImageView& a, const ImageView& b) {
  ASSERT_EQ(a.width_px, b.width_px);
  ASSERT_EQ(a.height_px, b.height_px);
  for (int y = 0; y < a.height_px; ++y)
    ASSERT_TRUE(std::equal(a.row(y), a.row(y) + a.width_px, b.row(y))) << "row " << y;
}

void expect_same(const ChromaView& a, const ChromaView& b) {
  ASSERT_EQ(a.width, b.width);
  ASSERT_EQ(a.height, b.height);
  for (int y = 0; y < a.height; ++y)
    for (int x = 0; x < a.width; ++x) {
      ASSERT_EQ(a.cb_at(x, y), b.cb_at(x, y)) << x << ' ' << y;
      ASSERT_EQ(a.cr_at(x, y), b.cr_at(x, y)) << x << ' ' << y;
    }
}

TEST_F(Tap, CarriesAPictureWhoseRowsHaveGaps) {
  TapWriter writer(path(), header_);
  TapReader reader(path());
  reader.announce(TapDemand::kEvery);
  const Picture picture(80);
  TapFrame frame;
  frame.number = 17;
  writer.publish(frame, picture.view(), {});
  TapCopy copy;
  ASSERT_TRUE(reader.copy_newest(copy));
  EXPECT_EQ(copy.frame.number, 17U);
  EXPECT_TRUE(copy.chroma().empty());
  expect_same(copy.luma(), picture.view());
}

TEST_F(Tap, CarriesColourAsEachKindOfCameraHasIt) {
  TapWriter writer(path(), header_);
  TapReader reader(path());
  reader.announce(TapDemand::kEvery);
  const Picture luma;
  std::vector<std::uint8_t> bytes(4 * 64 * 48);
  std::iota(bytes.begin(), bytes.end(), std::uint8_t{5});
  const std::uint8_t* const p = bytes.data();
  const std::vector<ChromaView> kinds{
      {p, p + 32 * 24, 32, 24, 1, 32},  // planes, YU12
      {p + 40 * 24, p, 32, 24, 1, 40},  // planes with gaps, YV12
      {p, p + 1, 32, 24, 2, 64},        // pairs, NV12
      {p + 1, p, 32, 24, 2, 70},        // pairs the other way, with gaps: NV21
      {p + 1, p + 3, 32, 48, 4, 128},   // between the luma, YUYV
      {p, p + 2, 32, 48, 4, 128},       // UYVY
      {p, p + 64 * 48, 64, 48, 1, 64},  // at every pixel, of a recording
  };
  TapCopy copy;
  for (const ChromaView& chroma : kinds) {
    TapFrame frame;
    writer.publish(frame, luma.view(), chroma);
    ASSERT_TRUE(reader.copy_newest(copy));
    expect_same(copy.luma(), luma.view());
    expect_same(copy.chroma(), chroma);
  }
}

TEST_F(Tap, LeavesOutAPictureThatIsLargerThanTheCalibrations) {
  TapWriter writer(path(), header_);
  TapReader reader(path());
  reader.announce(TapDemand::kEvery);
  const std::vector<std::uint8_t> bytes(1000 * 1000);
  TapFrame frame;
  frame.number = 3;
  writer.publish(frame, {bytes.data(), 1000, 1000, 1000}, {});
  TapCopy copy;
  ASSERT_TRUE(reader.copy_newest(copy));
  EXPECT_EQ(copy.frame.number, 3U);
  EXPECT_TRUE(copy.luma().empty());
}

TEST_F(Tap, NeverGivesAMixtureOfTwoFrames) {
  constexpr int kLargeWidth = 640, kLargeHeight = 480;
  header_.width_px = kLargeWidth, header_.height_px = kLargeHeight;
  TapWriter writer(path(), header_);
  std::atomic<bool> stop{false};
  std::atomic<std::uint64_t> copied{0}, mixed{0};
  const auto read = [&] {
    TapReader reader(path());
    reader.announce(TapDemand::kEvery);
    TapCopy copy;
    while (!stop) {
      if (!reader.copy_newest(copy)) continue;
      ++copied;
      const auto level = static_cast<std::uint8_t>(copy.frame.number);
      if (copy.frame.frames_processed != copy.frame.number || copy.frame.latency_bins.back() != copy.frame.number ||
          std::any_of(copy.pixels.begin(), copy.pixels.end(), [&](std::uint8_t p) { return p != level; }))
        ++mixed;
    }
  };
  // More than there are processors: most of them stand still in the middle of a copy, for many frames.
  std::vector<std::jthread> readers;
  for (unsigned i = 0; i < 2 * std::thread::hardware_concurrency() + 2; ++i) readers.emplace_back(read);
  std::vector<std::uint8_t> bytes(std::size_t{kLargeWidth} * kLargeHeight);
  TapFrame frame;
  for (const MonoTime end = mono_now() + 1500ms; mono_now() < end;) {
    ++frame.number;
    frame.frames_processed = static_cast<std::uint32_t>(frame.number);
    frame.latency_bins.back() = frame.frames_processed;
    std::fill(bytes.begin(), bytes.end(), static_cast<std::uint8_t>(frame.number));
    writer.publish(frame, {bytes.data(), kLargeWidth, kLargeHeight, kLargeWidth}, {});
  }
  stop = true;
  readers.clear();
  EXPECT_EQ(mixed, 0U) << "of " << copied;
  EXPECT_GT(copied, 10U);
}

TEST_F(Tap, KnowsWhetherAnybodyReads) {
  TapWriter writer(path(), header_);
  const auto is_read = [&] {
    writer.look_for_readers();
    return writer.demand() != TapDemand::kNothing;
  };
  EXPECT_FALSE(is_read());
  {
    TapReader reader(path()), other(path());
    EXPECT_FALSE(is_read()) << "open, but not reading";
    reader.announce(TapDemand::kEvery);
    EXPECT_TRUE(is_read());
    other.announce(TapDemand::kEvery);
    reader.announce(TapDemand::kNothing);
    EXPECT_TRUE(is_read()) << "one of two has left";
  }
  EXPECT_FALSE(is_read());
}

TEST_F(Tap, IsFilledAsTheMostDemandingReaderAsks) {
  TapWriter writer(path(), header_);
  const auto demand = [&] {
    writer.look_for_readers();
    return writer.demand();
  };
  TapReader page(path()), recording(path());
  page.announce(TapDemand::kSome);
  EXPECT_EQ(demand(), TapDemand::kSome);
  recording.announce(TapDemand::kEvery);
  EXPECT_EQ(demand(), TapDemand::kEvery);
  recording.announce(TapDemand::kSome);
  EXPECT_EQ(demand(), TapDemand::kSome);
}

TEST_F(Tap, ForgetsAReaderThatWasKilled) {
  TapWriter writer(path(), header_);
  std::array<int, 2> pipe{};
  ASSERT_EQ(::pipe(pipe.data()), 0);
  const pid_t child = ::fork();
  if (child == 0) {
    TapReader reader(path());
    reader.announce(TapDemand::kEvery);
    static_cast<void>(::write(pipe[1], "!", 1));
    for (;;) ::pause();
  }
  char ready = 0;
  ASSERT_EQ(::read(pipe[0], &ready, 1), 1);
  writer.look_for_readers();
  EXPECT_EQ(writer.demand(), TapDemand::kEvery);
  ::kill(child, SIGKILL);
  ASSERT_EQ(::waitpid(child, nullptr, 0), child);
  writer.look_for_readers();
  EXPECT_EQ(writer.demand(), TapDemand::kNothing);
  ::close(pipe[0]), ::close(pipe[1]);
}

TEST_F(Tap, GivesNothingThatIsOlderThanTheReading) {
  TapWriter writer(path(), header_);
  TapFrame frame;
  writer.publish(frame, {}, {});
  TapReader reader(path());
  reader.announce(TapDemand::kEvery);
  TapCopy copy;
  EXPECT_FALSE(reader.copy_newest(copy)) << "of whenever somebody read last";
  writer.publish(frame, {}, {});
  EXPECT_TRUE(reader.copy_newest(copy));
  EXPECT_FALSE(reader.copy_newest(copy)) << "given already";
}

TEST_F(Tap, CanBeReadByItsGroupAndWrittenByNobodyElse) {
  TapWriter writer(path(), header_);
  struct stat status {};
  ASSERT_EQ(::stat(path().c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0640U);
  const FileDescriptor file(::open(path().c_str(), O_RDONLY | O_CLOEXEC));
  EXPECT_EQ(::mmap(nullptr, 4096, PROT_WRITE, MAP_SHARED, file.get(), 0), MAP_FAILED) << "a reader's right suffices";
  EXPECT_EQ(::ftruncate(file.get(), 0), -1);
}

TEST_F(Tap, NeitherAllocatesNorMissesAPageWhileFramesCome) {
  TapWriter writer(path(), header_);
  TapReader reader(path());
  reader.announce(TapDemand::kEvery);
  const Picture picture(80);
  TapFrame frame;
  writer.publish(frame, picture.view(), {});
  const auto page_faults = [] {
    rusage usage{};
    ::getrusage(RUSAGE_THREAD, &usage);
    return usage.ru_minflt + usage.ru_majflt;
  };
  const test::AllocationGuard guard;
  const long before = page_faults();
  for (int i = 0; i < 30; ++i) writer.publish(frame, picture.view(), {});
  const long missed = page_faults() - before;
  EXPECT_EQ(guard.allocations() + guard.releases(), 0U);
  if (!test::kSanitized) {  // whose own pages come as they are touched
    EXPECT_EQ(missed, 0);
  }
}

TEST_F(Tap, OfOnePathIsServedByOneService) {
  const TapWriter writer(path(), header_);
  try {
    const TapWriter second(path(), header_);
    FAIL() << "both serve it";
  } catch (const StartupError& error) {
    EXPECT_NE(std::string(error.what()).find("another ninedotd serves this tap"), std::string::npos) << error.what();
  }
  EXPECT_EQ(refusal_of_reader(), "") << "the first one's is as it was";
}

TEST_F(Tap, OfAnEndedServiceIsRefusedAndReplaced) {
  { const TapWriter writer(path(), header_); }
  EXPECT_NE(refusal_of_reader().find("is ninedotd running"), std::string::npos);
  const pid_t child = ::fork();
  if (child == 0) {
    const TapWriter writer(path(), header_);
    ::kill(::getpid(), SIGKILL);
  }
  ASSERT_EQ(::waitpid(child, nullptr, 0), child);
  ASSERT_TRUE(std::filesystem::exists(path()));
  EXPECT_NE(refusal_of_reader().find("has ended"), std::string::npos);
  const TapWriter next(path(), header_);
  EXPECT_EQ(refusal_of_reader(), "");
}

TEST_F(Tap, ReplacesNothingThatIsNoTap) {
  const auto refusal = [&] {
    try {
      const TapWriter writer(path(), header_);
    } catch (const StartupError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  for (const std::string& name : {path(), path() + ".tmp"}) {
    for (const std::string text : {"precious\n", "p"}) {
      std::ofstream(name) << text;
      EXPECT_NE(refusal().find(name + ": File exists: this is no tap of ninedotd"), std::string::npos);
      std::string left;
      std::getline(std::ifstream(name), left, '\0');
      EXPECT_EQ(left, text);
      std::filesystem::remove(name);
    }
    ASSERT_EQ(::mkfifo(name.c_str(), 0600), 0);
    EXPECT_NE(refusal(), "") << "and waits for nobody";
    EXPECT_TRUE(std::filesystem::is_fifo(name));
    std::filesystem::remove(name);
    std::filesystem::create_symlink("/dev/null", name);
    EXPECT_NE(refusal(), "");
    EXPECT_TRUE(std::filesystem::is_symlink(name));
    std::filesystem::remove(name);
    std::ofstream(name) << std::string(64, '\0');
    EXPECT_EQ(refusal(), "") << "begun by a service that did not finish";
    EXPECT_FALSE(std::filesystem::exists(name));
  }
}

TEST_F(Tap, SaysOfAnotherVersionThatItIsOne) {
  TapWriter writer(path(), header_);
  std::fstream file(path(), std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(offsetof(TapHeader, version));
  file.put(static_cast<char>(kTapVersion + 1)).flush();
  EXPECT_NE(refusal_of_reader().find("version 3"), std::string::npos) << refusal_of_reader();
}

TEST_F(Tap, WhoseHeaderIsDamagedIsRefused) {
  const auto refused_after = [&](std::size_t offset, std::uint64_t value) {
    TapWriter writer(path(), header_);
    std::fstream file(path(), std::ios::in | std::ios::out | std::ios::binary);
    file.seekp(static_cast<std::streamoff>(offset));
    file.write(reinterpret_cast<const char*>(&value), sizeof value).flush();
    return !refusal_of_reader().empty();
  };
  EXPECT_TRUE(refused_after(offsetof(TapHeader, magic), 0));
  EXPECT_TRUE(refused_after(offsetof(TapHeader, segment_bytes), 1 << 30));
  EXPECT_TRUE(refused_after(offsetof(TapHeader, frame_slots_offset), ~0ULL - 100));
  EXPECT_TRUE(refused_after(offsetof(TapHeader, frame_slot_bytes), ~0ULL / 2));
  EXPECT_TRUE(refused_after(offsetof(TapHeader, pixels_offset), 8));
  EXPECT_TRUE(refused_after(offsetof(TapHeader, pixels_capacity), ~0ULL));
  EXPECT_TRUE(refused_after(offsetof(TapHeader, service_slots_offset), 1 << 30));
  EXPECT_TRUE(refused_after(offsetof(TapHeader, service_slot_bytes), 16));
  std::ofstream(path()) << "no tap";
  EXPECT_NE(refusal_of_reader().find("no tap of ninedotd"), std::string::npos);
}

TEST_F(Tap, CarriesWhatTheServiceSays) {
  TapWriter writer(path(), header_);
  TapReader reader(path());
  reader.announce(TapDemand::kEvery);
  TapService sent, got;
  sent.register_count = 146;
  sent.registers[3] = 0xBEEF;
  sent.client_count = 900;  // of a damaged one: never beyond what there is
  std::uint64_t seen = 0;
  EXPECT_FALSE(reader.copy_newest(seen, got));
  writer.publish(sent);
  ASSERT_TRUE(reader.copy_newest(seen, got));
  EXPECT_EQ(got.registers[3], 0xBEEF);
  EXPECT_EQ(got.client_count, kTapClientCount);
  EXPECT_FALSE(reader.copy_newest(seen, got));
}

TEST_F(Tap, OfAFolderThatIsNotThereIsRefusedInOneLine) {
  try {
    const TapWriter writer("/nowhere/tap", header_);
    FAIL();
  } catch (const StartupError& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    EXPECT_NE(std::string(error.what()).find("/nowhere/tap.tmp"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace ninedot
