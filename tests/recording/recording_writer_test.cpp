#include "drivers/recording/recording_writer.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <set>

#include "base/startup_error.h"
#include "drivers/recording/recording_source.h"
#include "tests/recording/temporary_recording.h"

namespace ninedot {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

/// Bytes that fit on the disk of these tests.
std::size_t room_bytes = 0;

/// Like write(2) on a disk that fills up: it takes what fits, then nothing.
ssize_t write_to_small_disk(int descriptor, const void* bytes, std::size_t count) {
  if (room_bytes == 0) {
    errno = ENOSPC;
    return -1;
  }
  const ssize_t written = ::write(descriptor, bytes, std::min(count, room_bytes));
  if (written > 0) room_bytes -= static_cast<std::size_t>(written);
  return written;
}

FrameLease frame_of(const std::vector<std::uint8_t>& pixels, int number, std::uint32_t dropped_before = 0) {
  FrameLease lease;
  lease.frame.luma = ImageView{pixels.data(), 8, 4, 8};
  lease.frame.set_exposure(MonoTime(number * 10ms + 5ns));
  lease.dropped_before = dropped_before;
  return lease;
}

std::set<std::string> files_below(const std::string& folder) {
  std::set<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files.insert(fs::relative(entry.path(), folder).string());
  return files;
}

TEST(RecordingWriter, WritesARecordingThatReadsBack) {
  const TemporaryRecording temporary(0);
  const std::string folder = temporary.path() + "/new/recording";
  std::vector<std::uint8_t> pixels(32);
  {
    RecordingWriter writer(folder, "calibration\n");
    for (int i = 0; i < 3; ++i) {
      pixels[9] = static_cast<std::uint8_t>(10 * i);
      FrameLease frame = frame_of(pixels, i, i == 2 ? 4 : 0);
      frame.frame.head = HeadAngles{0.25, 0};
      EXPECT_EQ(*writer.add(frame), i == 2 ? 6U : static_cast<unsigned>(i));
    }
  }
  EXPECT_EQ(files_below(folder), (std::set<std::string>{"camera.yaml", "frames.csv", "frames/000000.png",
                                                        "frames/000001.png", "frames/000006.png"}));
  RecordingSource source(folder, {});
  for (int i = 0; i < 3; ++i) {
    const Result<FrameLease> frame = source.next(mono_now() + 5s);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->frame.luma.at(1, 1), 10 * i);
    EXPECT_EQ(frame->frame.exposed_at(), MonoTime(i * 10ms + 5ns));
    EXPECT_DOUBLE_EQ(frame->frame.head->pan_rad, 0.25);
  }
}

TEST(RecordingWriter, KeepsTheColourOfACameraAndItsLumaToTheBit) {
  // As a camera's NV12 has it: a Cb and a Cr for 2 x 2 pixels, side by side, rows longer than the picture.
  constexpr int kWidth = 8, kHeight = 4, kStride = 10;
  std::vector<std::uint8_t> pixels(kStride * kHeight * 3 / 2);
  for (std::size_t i = 0; i < pixels.size(); ++i)
    pixels[i] = static_cast<std::uint8_t>(i < kStride * kHeight ? 60 + 3 * i : 100 + i % 50);
  const std::uint8_t* const colour = pixels.data() + kStride * kHeight;
  FrameLease lease;
  lease.frame.luma = ImageView{pixels.data(), kWidth, kHeight, kStride};
  lease.frame.chroma = ChromaView{colour, colour + 1, kWidth / 2, kHeight / 2, 2, kStride};
  const TemporaryRecording temporary(0);
  const std::string folder = temporary.path() + "/recording";
  {
    RecordingWriter writer(folder, "");
    ASSERT_TRUE(writer.add(lease));
  }
  RecordingSource source(folder, {});
  const Result<FrameLease> read = source.next(mono_now() + 5s);
  ASSERT_TRUE(read);
  ASSERT_EQ(read->frame.chroma.width, kWidth);
  ASSERT_EQ(read->frame.chroma.height, kHeight);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      EXPECT_EQ(read->frame.luma.at(x, y), lease.frame.luma.at(x, y));
      EXPECT_EQ(read->frame.chroma.cb_at(x, y), lease.frame.chroma.cb_at(x / 2, y / 2));
      EXPECT_EQ(read->frame.chroma.cr_at(x, y), lease.frame.chroma.cr_at(x / 2, y / 2));
    }
}

TEST(RecordingWriter, KeepsAReadableRecordingWhereverTheDiskGetsFull) {
  const std::vector<std::uint8_t> pixels(32, 77);
  for (std::size_t room = 0; room < 700; room += 3) {
    const TemporaryRecording temporary(0);
    const std::string folder = temporary.path() + "/recording";
    room_bytes = room;
    std::uint64_t recorded = 0;
    try {
      RecordingWriter writer(folder, "calibration\n", write_to_small_disk);
      for (int i = 0; i < 20; ++i) {
        const Result<std::uint64_t> number = writer.add(frame_of(pixels, i));
        if (number) continue;
        EXPECT_EQ(number.error().code, Errc::kIo);
        EXPECT_EQ(number.error().os_errno, ENOSPC);
        break;
      }
      recorded = writer.frame_count();
      ASSERT_LT(recorded, 20U);
    } catch (const StartupError& error) {
      EXPECT_NE(std::string(error.what()).find("No space left on device"), std::string::npos);
    }
    if (recorded == 0) {
      EXPECT_FALSE(fs::exists(folder)) << room;
      continue;
    }
    EXPECT_EQ(files_below(folder).size(), recorded + 2) << room;
    RecordingSource source(folder, {});
    EXPECT_EQ(source.frame_count(), recorded);
    for (std::uint64_t i = 0; i < recorded; ++i) ASSERT_TRUE(source.next(mono_now() + 5s)) << room;
  }
}

TEST(RecordingWriter, CarriesOnOnceThereIsRoomAgain) {
  const TemporaryRecording temporary(0);
  const std::string folder = temporary.path() + "/recording";
  const std::vector<std::uint8_t> pixels(32, 77);
  room_bytes = 100000;
  {
    RecordingWriter writer(folder, "", write_to_small_disk);
    EXPECT_TRUE(writer.add(frame_of(pixels, 0)));
    room_bytes = 90;  // less than a picture and its row
    EXPECT_FALSE(writer.add(frame_of(pixels, 1)));
    room_bytes = 100000;
    EXPECT_TRUE(writer.add(frame_of(pixels, 2)));
  }
  EXPECT_EQ(files_below(folder), (std::set<std::string>{"frames.csv", "frames/000000.png", "frames/000001.png"}));
  EXPECT_EQ(RecordingSource(folder, {}).frame_count(), 2U);
}

TEST(RecordingWriter, RefusesAFolderThatIsNotEmptyAndLeavesItAlone) {
  const TemporaryRecording recording(1);
  try {
    RecordingWriter writer(recording.path(), "");
    FAIL();
  } catch (const StartupError& error) {
    EXPECT_EQ(error.status, ExitStatus::kWrongUsage);
    EXPECT_EQ(error.what(),
              recording.path() + ": is there already and not empty; give a new folder, or empty this one");
  }
  EXPECT_EQ(files_below(recording.path()), (std::set<std::string>{"frames/000000.pgm"}));
}

TEST(RecordingWriter, RemovesOnlyWhatItMadeWhenNothingWasRecorded) {
  const TemporaryRecording temporary(0);
  { RecordingWriter writer(temporary.path() + "/a/b/c", "calibration\n"); }
  EXPECT_FALSE(fs::exists(temporary.path() + "/a"));
  EXPECT_TRUE(fs::exists(temporary.path()));
  fs::create_directory(temporary.path() + "/empty");
  { RecordingWriter writer(temporary.path() + "/empty", "calibration\n"); }
  EXPECT_TRUE(fs::is_empty(temporary.path() + "/empty"));
}

TEST(RecordingWriter, SaysWhyItCantMakeItsFolder) {
  const TemporaryRecording recording(1);
  try {
    RecordingWriter writer(recording.picture(0) + "/below-a-file", "");
    FAIL();
  } catch (const StartupError& error) {
    EXPECT_EQ(error.status, ExitStatus::kWorkFailed);
    EXPECT_NE(std::string(error.what()).find("can't be made: Not a directory"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace ninedot
