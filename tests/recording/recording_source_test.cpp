#include "drivers/recording/recording_source.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <future>
#include <numbers>
#include <thread>
#include <vector>

#include "base/startup_error.h"
#include "tests/recording/temporary_recording.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;
namespace fs = std::filesystem;

MonoTime soon() { return mono_now() + 5s; }

std::string bundled(const std::string& name) { return std::string(NINEDOT_SOURCE_DIR) + "/tests/recordings/" + name; }

std::string startup_error_of(const std::string& path) {
  try {
    RecordingSource source(path, {});
  } catch (const StartupError& error) {
    EXPECT_EQ(error.status, ExitStatus::kWorkFailed);
    return error.what();
  }
  return "";
}

TEST(RecordingSource, GivesEveryFrameOfTheBundledApproachOnceAndInOrder) {
  RecordingSource source(bundled("approach"), {});
  EXPECT_EQ(source.size(), (PictureSize{640, 480}));
  EXPECT_EQ(source.frame_count(), 22U);
  for (std::uint64_t i = 0; i < 22; ++i) {
    const Result<FrameLease> frame = source.next(soon());
    ASSERT_TRUE(frame) << frame.error().text;
    EXPECT_EQ(frame->frame.number, 3 * i);
    EXPECT_EQ(frame->dropped_before, 0U);
    EXPECT_NEAR(static_cast<double>(to_ns(frame->frame.exposed_at())), static_cast<double>(3 * i) * 1e9 / 35, 1.0);
    EXPECT_EQ(frame->frame.luma.width_px, 640);
  }
  const Result<FrameLease> end = source.next(soon());
  ASSERT_FALSE(end);
  EXPECT_EQ(end.error().code, Errc::kEndOfStream);
}

TEST(RecordingSource, WaitsForASlowReaderSoThatNoFrameIsLost) {
  const TemporaryRecording recording(20);
  RecordingSource source(recording.path(), {});
  for (std::uint8_t i = 0; i < 20; ++i) {
    if (i % 5 == 0) std::this_thread::sleep_for(10ms);
    const Result<FrameLease> frame = source.next(soon());
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->frame.luma.at(3, 2), i);
  }
}

TEST(RecordingSource, LetsTheNewestFrameWinInRealTimeAndCountsTheOthers) {
  const TemporaryRecording recording(60);
  RecordingSource source(recording.path(), {.pace = RecordingPace::kRealTime, .rate_hz = 200});
  std::uint64_t taken = 0, dropped = 0, last = 0;
  MonoTime last_exposed_at{};
  for (;;) {
    const Result<FrameLease> frame = source.next(soon());
    if (!frame) {
      EXPECT_EQ(frame.error().code, Errc::kEndOfStream);
      break;
    }
    EXPECT_EQ(frame->frame.luma.at(0, 0), frame->frame.number);
    EXPECT_LE(frame->frame.exposed_at(), mono_now());
    EXPECT_GT(frame->frame.exposed_at(), last_exposed_at);
    last_exposed_at = frame->frame.exposed_at();
    last = frame->frame.number;
    ++taken;
    dropped += frame->dropped_before;
    std::this_thread::sleep_for(23ms);  // longer than four frames
  }
  EXPECT_EQ(last, 59U);
  EXPECT_EQ(taken + dropped, 60U);
  EXPECT_GE(dropped, 30U);
}

TEST(RecordingSource, PacesFramesByTheirRecordedTimes) {
  TemporaryRecording recording(3);
  recording.write("frames.csv", "frame,timestamp_ns\n0,1000000000\n1,1050000000\n2,1060000000\n");
  RecordingSource source(recording.path(), {.pace = RecordingPace::kRealTime});
  const Result<FrameLease> first = source.next(soon());
  const Result<FrameLease> second = source.next(soon());
  const Result<FrameLease> third = source.next(soon());
  ASSERT_TRUE(first && second && third);
  EXPECT_EQ(second->frame.exposed_at() - first->frame.exposed_at(), 50ms);
  EXPECT_EQ(third->frame.exposed_at() - second->frame.exposed_at(), 10ms);
}

TEST(RecordingSource, SaysSoWhenNoFrameComesBeforeTheDeadline) {
  const TemporaryRecording recording(2);
  RecordingSource source(recording.path(), {.pace = RecordingPace::kRealTime, .rate_hz = 2});
  ASSERT_TRUE(source.next(soon()));
  const Result<FrameLease> none = source.next(mono_now() + 20ms);
  ASSERT_FALSE(none);
  EXPECT_EQ(none.error().code, Errc::kNoFrame);
  EXPECT_TRUE(source.next(soon()));
}

class LoopedRecording : public testing::TestWithParam<std::size_t> {};

TEST_P(LoopedRecording, KeepsNumbersAndTimesGrowing) {
  const TemporaryRecording recording(5);
  RecordingSource source(recording.path(), {.loop = true, .preload_bytes = GetParam()});
  MonoTime last{-1ns};
  for (std::uint64_t i = 0; i < 23; ++i) {
    const Result<FrameLease> frame = source.next(soon());
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->frame.number, i);
    EXPECT_EQ(frame->frame.luma.at(1, 1), i % 5);
    EXPECT_GT(frame->frame.exposed_at(), last);
    EXPECT_NEAR(static_cast<double>(to_ns(frame->frame.exposed_at())), static_cast<double>(i) * 1e9 / 35, 10.0);
    last = frame->frame.exposed_at();
  }
}
INSTANTIATE_TEST_SUITE_P(DecodedOnceAndDecodedEachTime, LoopedRecording,
                         testing::Values(std::size_t{1} << 20U, std::size_t{0}));

/// Red, then grey, then blue: 2 x 1 px each.
void write_colours(const TemporaryRecording& recording) {
  const auto ppm = [](const std::string& pixel) { return "P6 2 1 255\n" + pixel + pixel; };
  recording.write("frames/000000.ppm", ppm({'\xC8', '\x1E', '\x1E'}));
  recording.write("frames/000001.pgm", "P5 2 1 255\n~~");
  recording.write("frames/000002.ppm", ppm({'\x1E', '\x1E', '\xC8'}));
}

class RecordingAsTaken : public testing::TestWithParam<std::size_t> {};

TEST_P(RecordingAsTaken, GivesEveryFrameOnceAtTheInstantAtWhichItIsTakenWhateverTheRate) {
  const TemporaryRecording recording(5);
  RecordingSource source(recording.path(),
                         {.pace = RecordingPace::kAsTaken, .rate_hz = 0.1, .loop = true, .preload_bytes = GetParam()});
  for (std::uint64_t i = 0; i < 23; ++i) {
    if (i % 5 == 0) std::this_thread::sleep_for(10ms);
    const MonoTime asked_at = mono_now();
    const Result<FrameLease> frame = source.next(soon());
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->frame.number, i);
    EXPECT_EQ(frame->frame.luma.at(1, 1), i % 5);
    EXPECT_EQ(frame->dropped_before, 0U);
    EXPECT_GE(frame->frame.exposed_at(), asked_at);
    EXPECT_LE(frame->frame.exposed_at(), mono_now());
    EXPECT_EQ(frame->frame.head_at, frame->frame.exposed_at());
  }
}
INSTANTIATE_TEST_SUITE_P(DecodedOnceAndDecodedEachTime, RecordingAsTaken,
                         testing::Values(std::size_t{1} << 20U, std::size_t{0}));

TEST(RecordingSource, EndsAlsoAsTaken) {
  const TemporaryRecording recording(3);
  RecordingSource source(recording.path(), {.pace = RecordingPace::kAsTaken});
  for (int i = 0; i < 3; ++i) EXPECT_TRUE(source.next(soon()));
  const Result<FrameLease> end = source.next(soon());
  ASSERT_FALSE(end);
  EXPECT_EQ(end.error().code, Errc::kEndOfStream);
}

class ColouredRecording : public testing::TestWithParam<std::size_t> {};

TEST_P(ColouredRecording, LendsTheColourOfThoseFramesThatHaveOne) {
  const TemporaryRecording recording(0);
  write_colours(recording);
  RecordingSource source(recording.path(), {.loop = true, .preload_bytes = GetParam()});
  for (int pass = 0; pass < 3; ++pass) {
    const Result<FrameLease> red = source.next(soon()), grey = source.next(soon()), blue = source.next(soon());
    ASSERT_TRUE(red && grey && blue);
    ASSERT_FALSE(red->frame.chroma.empty());
    EXPECT_EQ(red->frame.luma.at(1, 0), luma_from_rgb(0xC8, 0x1E, 0x1E));
    EXPECT_EQ(red->frame.chroma.cr_at(1, 0), cr_from_rgb(0xC8, 0x1E, 0x1E));
    EXPECT_TRUE(grey->frame.chroma.empty());
    EXPECT_EQ(grey->frame.luma.at(1, 0), '~');
    EXPECT_EQ(blue->frame.chroma.cb_at(0, 0), cb_from_rgb(0x1E, 0x1E, 0xC8));
  }
}
// All of them in memory; the luma would fit but not the colour; not asked for.
INSTANTIATE_TEST_SUITE_P(DecodedOnceAndDecodedEachTime, ColouredRecording,
                         testing::Values(std::size_t{14}, std::size_t{13}, std::size_t{0}));

TEST(RecordingSource, CarriesPanAndTiltOfFramesCsv) {
  TemporaryRecording recording(1);
  recording.write("frames.csv", "frame,timestamp_ns,pan_deg,tilt_deg\n0,5,90,-45\n");
  RecordingSource source(recording.path(), {});
  const Result<FrameLease> frame = source.next(soon());
  ASSERT_TRUE(frame);
  EXPECT_DOUBLE_EQ(frame->frame.head->pan_rad, std::numbers::pi / 2);
  EXPECT_DOUBLE_EQ(frame->frame.head->tilt_rad, -std::numbers::pi / 4);
}

TEST(RecordingSource, GivesAnErrorInThePlaceOfAMissingPicture) {
  const TemporaryRecording recording(3);
  fs::remove(recording.picture(1));
  RecordingSource source(recording.path(), {});
  ASSERT_TRUE(source.next(soon()));
  const Result<FrameLease> missing = source.next(soon());
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, Errc::kFrameUnreadable);
  EXPECT_EQ(std::string(source.last_failure()), recording.picture(1) + ": frame 1: the picture is missing");
  const Result<FrameLease> next = source.next(soon());
  ASSERT_TRUE(next);
  EXPECT_EQ(next->frame.number, 2U);
}

TEST(RecordingSource, GivesAnErrorInThePlaceOfATruncatedPicture) {
  const TemporaryRecording recording(3);
  fs::resize_file(recording.picture(2), 20);
  RecordingSource source(recording.path(), {});
  ASSERT_TRUE(source.next(soon()));
  ASSERT_TRUE(source.next(soon()));
  const Result<FrameLease> truncated = source.next(soon());
  ASSERT_FALSE(truncated);
  EXPECT_EQ(truncated.error().code, Errc::kFrameUnreadable);
  EXPECT_EQ(source.next(soon()).error().code, Errc::kEndOfStream);
}

TEST(RecordingSource, GivesAnErrorInThePlaceOfAPictureOfAnotherSize) {
  TemporaryRecording recording(2);
  recording.write("frames/000001.pgm", "P5 2 1 255\nab");
  RecordingSource source(recording.path(), {});
  ASSERT_TRUE(source.next(soon()));
  const Result<FrameLease> wrong = source.next(soon());
  ASSERT_FALSE(wrong);
  EXPECT_EQ(wrong.error().code, Errc::kFrameSize);
}

TEST(RecordingSource, FailsWithEveryFrameWhenTheCalibrationIsForAnotherSize) {
  const TemporaryRecording recording(1);
  RecordingSource source(recording.path(), {.size = {640, 480}});
  EXPECT_EQ(source.next(soon()).error().code, Errc::kFrameSize);
}

TEST(RecordingSource, KeepsFailingFramesInALoopedRecordingThatIsDecodedOnce) {
  const TemporaryRecording recording(2);
  fs::resize_file(recording.picture(1), 10);
  RecordingSource source(recording.path(), {.loop = true});
  for (int pass = 0; pass < 3; ++pass) {
    EXPECT_TRUE(source.next(soon()));
    EXPECT_EQ(source.next(soon()).error().code, Errc::kFrameUnreadable);
  }
}

TEST(RecordingSource, SurvivesACallerThatHoldsEveryBuffer) {
  const TemporaryRecording recording(1000);  // two seconds: it goes on also while a busy machine stands still
  RecordingSource source(recording.path(), {.pace = RecordingPace::kRealTime, .rate_hz = 500});
  std::vector<FrameLease> held;
  for (std::size_t i = 0; i < RecordingSource::kBufferCount; ++i) {
    Result<FrameLease> frame = source.next(soon());
    ASSERT_TRUE(frame);
    held.push_back(std::move(*frame));
  }
  EXPECT_EQ(source.next(mono_now() + 30ms).error().code, Errc::kNoFrame);
  const std::uint64_t last = held.back().frame.number;
  held.clear();
  const Result<FrameLease> later = source.next(soon());
  ASSERT_TRUE(later);
  EXPECT_EQ(later->dropped_before, later->frame.number - last - 1);
}

TEST(RecordingSource, CanBeDestroyedWhileItsThreadWaits) {
  const TemporaryRecording recording(10);
  { RecordingSource never_asked(recording.path(), {.pace = RecordingPace::kRealTime}); }
  { RecordingSource queue_full(recording.path(), {}); }
  RecordingSource asked(recording.path(), {.pace = RecordingPace::kRealTime, .rate_hz = 0.1, .loop = true});
  ASSERT_TRUE(asked.next(soon()));
}

TEST(RecordingIndex, RefusesAFolderWithoutPicturesInOneLine) {
  TemporaryRecording recording(0);
  EXPECT_EQ(startup_error_of(recording.path()),
            recording.path() + "/frames: no picture in it; expected NNNNNN.png, .pgm, .ppm or .jpg");
}

TEST(RecordingIndex, RefusesWhatIsNoRecording) {
  const TemporaryRecording recording(1);
  EXPECT_EQ(startup_error_of("/nonexistent/recording"), "/nonexistent/recording: no such recording");
  EXPECT_EQ(startup_error_of(recording.path() + "/frames"),
            recording.path() + "/frames: not a recording: there is no folder 'frames' in it");
  EXPECT_EQ(startup_error_of(recording.picture(0)),
            recording.picture(0) + ": not a recording: a folder with frames/ in it, or a .y4m file");
}

TEST(RecordingIndex, NamesFileAndLineOfADamagedFramesCsv) {
  TemporaryRecording recording(2);
  recording.write("frames.csv", "frame,timestamp_ns\n0,0\n1,x\n");
  EXPECT_EQ(startup_error_of(recording.path()), recording.path() +
                                                    "/frames.csv:3: timestamp_ns is not a whole number from 0 to "
                                                    "4000000000000000000");
}

TEST(RecordingIndex, RefusesAPictureThatFramesCsvDoesNotList) {
  TemporaryRecording recording(2);
  recording.write("frames.csv", "frame,timestamp_ns\n0,0\n");
  EXPECT_NE(startup_error_of(recording.path()).find("000001.pgm is not listed"), std::string::npos);
}

TEST(RecordingIndex, RefusesTwoPicturesOfTheSameNumber) {
  TemporaryRecording recording(1);
  recording.write("frames/0.pgm", "P5 2 1 255\nab");
  EXPECT_NE(startup_error_of(recording.path()).find("has the same number"), std::string::npos);
}

TEST(RecordingIndex, RefusesHugeGapsInTheNumbers) {
  TemporaryRecording recording(1);
  recording.write("frames/900000000.pgm", "P5 2 1 255\nab");
  EXPECT_NE(startup_error_of(recording.path()).find("list them in frames.csv"), std::string::npos);
}

TEST(RecordingIndex, RefusesARecordingOfUnreadablePicturesOnly) {
  TemporaryRecording recording(0);
  recording.write("frames/000000.png", "not a picture");
  EXPECT_NE(startup_error_of(recording.path()).find("000000.png: not a readable picture"), std::string::npos);
}

/// They have no contents, so that they take no room; but they would take all memory.
TEST(RecordingIndex, NamesAFileThatIsTooLongForWhatItIsSaidToBe) {
  TemporaryRecording recording(2);
  fs::resize_file(recording.picture(1), std::uintmax_t{400} << 20U);
  EXPECT_EQ(startup_error_of(recording.path()),
            recording.picture(1) + ": longer than 320 MiB, as no picture is; remove it");
  fs::resize_file(recording.picture(1), 43);
  EXPECT_EQ(startup_error_of(recording.path()), "");
  recording.write("frames.csv", "frame,timestamp_ns\n0,0\n1,5\n");
  fs::resize_file(recording.path() + "/frames.csv", std::uintmax_t{200} << 20U);
  EXPECT_EQ(startup_error_of(recording.path()),
            recording.path() + "/frames.csv: longer than 128 MiB; is it the right file?");
}

TEST(RecordingIndex, RefusesTimesThatJumpByYears) {
  TemporaryRecording recording(2);
  recording.write("frames.csv", "frame,timestamp_ns\n0,0\n1,4000000000000000000\n");
  EXPECT_NE(startup_error_of(recording.path()).find("lasts more than a year"), std::string::npos);
}

/// What a recording in which `fifo` is one is refused with: at once, for whoever waits for a fifo hears no signal.
std::string refusal_of_fifo(const std::string& recording, const std::string& fifo) {
  EXPECT_EQ(::mkfifo(fifo.c_str(), 0600), 0);
  std::string refusal;
  auto opening = std::async(std::launch::async, [&] {
    try {
      const RecordingSource source(recording, {});
    } catch (const StartupError& error) {
      EXPECT_EQ(error.status, ExitStatus::kWrongUsage);
      refusal = error.what();
    }
  });
  while (opening.wait_for(10s) != std::future_status::ready) {
    ADD_FAILURE() << "waits without end";
    ::close(::open(fifo.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC));
  }
  return refusal;
}

TEST(RecordingSource, WaitsForNoFifo) {
  const TemporaryRecording recording(1);
  const std::string y4m = recording.path() + "/pipe.y4m", csv = recording.path() + "/frames.csv";
  EXPECT_EQ(refusal_of_fifo(y4m, y4m), y4m + ": is a pipe: a recording is read more than once");
  EXPECT_EQ(refusal_of_fifo(recording.path(), csv), csv + ": is a pipe: a recording is read more than once");
}

}  // namespace
}  // namespace ninedot
