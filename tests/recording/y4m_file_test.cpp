#include "drivers/recording/y4m_file.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "base/startup_error.h"
#include "drivers/recording/recording_source.h"
#include "tests/recording/temporary_recording.h"

namespace ninedot {
namespace {

using namespace std::chrono_literals;

std::span<const std::uint8_t> bytes_of(const std::string& text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

TEST(Y4mHeader, KnowsSizeRateAndChromaOfEachKind) {
  const auto chroma_of = [](const std::string& kind) {
    const auto header = parse_y4m_header(bytes_of("YUV4MPEG2 W5 H3 F30000:1001 Ip A1:1 " + kind + "\n"));
    return header ? static_cast<int>(2 * header->chroma_size.pixel_count()) : -1;
  };
  EXPECT_EQ(chroma_of("Cmono"), 0);
  EXPECT_EQ(chroma_of(""), 12);  // 4:2:0 unless it says otherwise; odd sides round up
  EXPECT_EQ(chroma_of("C420jpeg"), 12);
  EXPECT_EQ(chroma_of("C422"), 18);
  EXPECT_EQ(chroma_of("C444"), 30);
  EXPECT_EQ(chroma_of("C420p10"), -1);
  EXPECT_EQ(chroma_of("Cmono16"), -1);
  EXPECT_NEAR(parse_y4m_header(bytes_of("YUV4MPEG2 W5 H3 F30000:1001\n"))->rate_hz, 29.97, 0.001);
  EXPECT_EQ(parse_y4m_header(bytes_of("YUV4MPEG2 W5 H3 F0:0\n"))->rate_hz, 0);
}

TEST(Y4mHeader, RefusesDamagedOnes) {
  for (const char* const text :
       {"", "YUV4MPEG2", "YUV4MPEG2 W5 H3", "YUV4MPEG2\n", "YUV4MPEG2 W5\n", "YUV4MPEG2 W0 H3\n", "YUV4MPEG2 W5 H-3\n",
        "YUV4MPEG2 W5 H9000\n", "YUV4MPEG2 W5 H3 It\n", "YUV4MPEG W5 H3\n", "YUV4MPEG2X W5 H3\n"})
    EXPECT_FALSE(parse_y4m_header(bytes_of(text))) << text;
  EXPECT_FALSE(parse_y4m_frame_header(bytes_of("FRAM\n")));
  EXPECT_FALSE(parse_y4m_frame_header(bytes_of("FRAME")));
  EXPECT_EQ(*parse_y4m_frame_header(bytes_of("FRAME Ip\n")), 9U);
}

std::string three_frames(const std::string& second_header = "FRAME\n") {
  return "YUV4MPEG2 W2 H1 F10:1 C444\nFRAME Xa=b\nab1234" + second_header + "cd1234FRAME\nef1234";
}

TEST(Y4mRecording, GivesItsFramesAtItsRate) {
  const TemporaryRecording folder(0);
  folder.write("a.y4m", three_frames());
  RecordingSource source(folder.path() + "/a.y4m", {});
  ASSERT_EQ(source.frame_count(), 3U);
  for (int i = 0; i < 3; ++i) {
    const Result<FrameLease> frame = source.next(mono_now() + 5s);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->frame.luma.at(1, 0), "bdf"[i]);
    EXPECT_EQ(frame->frame.exposed_at(), MonoTime(i * 100ms));
  }
  EXPECT_EQ(source.next(mono_now() + 5s).error().code, Errc::kEndOfStream);
}

TEST(Y4mRecording, LendsTheColourPlanesThatFollowTheLuma) {
  const TemporaryRecording folder(0);
  folder.write("a.y4m", "YUV4MPEG2 W3 H2 C420\nFRAME\nabcdefuvwx");
  folder.write("b.y4m", "YUV4MPEG2 W3 H1 C422\nFRAME\nabcuvwx");
  folder.write("c.y4m", "YUV4MPEG2 W3 H1 Cmono\nFRAME\nabc");
  folder.write("d.y4m", "YUV4MPEG2 W3 H1 C422\nFRAME\nabcuv");
  for (const char* const name : {"/a.y4m", "/b.y4m"}) {
    RecordingSource source(folder.path() + name, {});
    const Result<FrameLease> frame = source.next(mono_now() + 5s);
    ASSERT_TRUE(frame);
    EXPECT_EQ(frame->frame.luma.at(2, 0), 'c');
    const ChromaView& chroma = frame->frame.chroma;
    ASSERT_EQ(chroma.width, 2);
    ASSERT_EQ(chroma.height, 1);
    EXPECT_EQ(chroma.cb_at(0, 0), 'u');
    EXPECT_EQ(chroma.cb_at(1, 0), 'v');
    EXPECT_EQ(chroma.cr_at(0, 0), 'w');
    EXPECT_EQ(chroma.cr_at(1, 0), 'x');
  }
  for (const char* const name : {"/c.y4m", "/d.y4m"}) {  // it has none; it was cut off
    RecordingSource source(folder.path() + name, {});
    const Result<FrameLease> frame = source.next(mono_now() + 5s);
    ASSERT_TRUE(frame);
    EXPECT_TRUE(frame->frame.chroma.empty());
    EXPECT_EQ(frame->frame.luma.at(2, 0), 'c');
  }
}

TEST(Y4mRecording, GivesAnErrorForATruncatedLastFrame) {
  const TemporaryRecording folder(0);
  std::string text = three_frames();
  text.resize(text.size() - 5);  // one byte of luma is left
  folder.write("a.y4m", text);
  RecordingSource source(folder.path() + "/a.y4m", {});
  EXPECT_TRUE(source.next(mono_now() + 5s));
  EXPECT_TRUE(source.next(mono_now() + 5s));
  EXPECT_EQ(source.next(mono_now() + 5s).error().code, Errc::kFrameUnreadable);
  EXPECT_EQ(std::string(source.last_failure()), folder.path() + "/a.y4m: frame 2: the file is truncated");
}

TEST(Y4mRecording, EndsWithAnErrorWhereAFrameHeaderIsDamaged) {
  const TemporaryRecording folder(0);
  folder.write("a.y4m", three_frames("FRUME\n"));
  RecordingSource source(folder.path() + "/a.y4m", {});
  EXPECT_TRUE(source.next(mono_now() + 5s));
  EXPECT_EQ(source.next(mono_now() + 5s).error().code, Errc::kFrameUnreadable);
  EXPECT_EQ(source.next(mono_now() + 5s).error().code, Errc::kEndOfStream);
}

TEST(Y4mRecording, RefusesAFileWithoutFrames) {
  const TemporaryRecording folder(0);
  folder.write("a.y4m", "YUV4MPEG2 W2 H1\n");
  EXPECT_THROW(RecordingSource(folder.path() + "/a.y4m", {}), StartupError);
}

}  // namespace
}  // namespace ninedot
