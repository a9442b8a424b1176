#include "proto/frames_csv.h"

#include <gtest/gtest.h>

namespace ninedot {
namespace {

std::string error_of(std::string_view text) {
  const auto rows = parse_frames_csv(text);
  return rows ? "" : std::to_string(rows.error().line) + ": " + rows.error().what;
}

TEST(FramesCsv, ReadsBackWhatItWrote) {
  const std::vector<FramesCsvRow> rows{
      {0, 0, 0, 0, {}}, {3, 85714286, -12.25, 0.1, {}}, {999999999, 4000000000000000000, 360, -360, {}}};
  std::string text(kFramesCsvHeader);
  for (const FramesCsvRow& row : rows) text += format_frames_csv_row(row);
  const auto read = parse_frames_csv(text);
  ASSERT_TRUE(read) << read.error().what;
  ASSERT_EQ(read->size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    EXPECT_EQ((*read)[i].frame, rows[i].frame);
    EXPECT_EQ((*read)[i].timestamp_ns, rows[i].timestamp_ns);
    EXPECT_EQ((*read)[i].pan_deg, rows[i].pan_deg);
    EXPECT_EQ((*read)[i].tilt_deg, rows[i].tilt_deg);
  }
}

TEST(FramesCsv, QuotesAColumnInOneShortLineThatATerminalMayShow) {
  const auto what = [](const std::string& name) { return parse_frames_csv("frame," + name + "\n").error().what; };
  EXPECT_EQ(what("\x1b[2J\a"), "unknown column '?[2J?'; there are frame,timestamp_ns,pan_deg,tilt_deg,zoom");
  EXPECT_EQ(what(std::string(1000, 'x')),
            "unknown column '" + std::string(40, 'x') + "...'; there are frame,timestamp_ns,pan_deg,tilt_deg,zoom");
}

TEST(FramesCsv, HasTheZoomWhereTheCameraToldIt) {
  const std::vector<FramesCsvRow> rows{{0, 0, 0, 0, 0}, {1, 5, 1, 0, {}}, {2, 9, 0, 0, 1023}};
  std::string text(kFramesCsvHeaderWithZoom);
  for (const FramesCsvRow& row : rows) text += format_frames_csv_row(row, true);
  EXPECT_EQ(text, "frame,timestamp_ns,pan_deg,tilt_deg,zoom\n0,0,0,0,0\n1,5,1,0,\n2,9,0,0,1023\n");
  const auto read = parse_frames_csv(text);
  ASSERT_TRUE(read) << read.error().what;
  ASSERT_EQ(read->size(), rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_EQ((*read)[i].zoom, rows[i].zoom);
}

TEST(FramesCsv, TakesColumnsInAnyOrderWithoutAnglesAndWithCrLf) {
  const auto rows = parse_frames_csv("timestamp_ns,frame\r\n5,1\r\n9,2");
  ASSERT_TRUE(rows) << rows.error().what;
  ASSERT_EQ(rows->size(), 2U);
  EXPECT_EQ((*rows)[1].frame, 2U);
  EXPECT_EQ((*rows)[1].timestamp_ns, 9);
  EXPECT_EQ((*rows)[1].pan_deg, 0);
}

TEST(FramesCsv, NamesTheLineOfEveryMistake) {
  EXPECT_EQ(error_of(""), "1: the file is empty; write the header frame,timestamp_ns,pan_deg,tilt_deg");
  EXPECT_EQ(error_of("frame\n"), "1: column 'timestamp_ns' is missing");
  EXPECT_EQ(error_of("frame,timestamp_ns,focus\n"),
            "1: unknown column 'focus'; there are frame,timestamp_ns,pan_deg,tilt_deg,zoom");
  EXPECT_EQ(error_of("frame,timestamp_ns,zoom\n1,5,12.5\n"), "2: zoom is not a whole number from 0 to 65535");
  EXPECT_EQ(error_of("frame,timestamp_ns,zoom\n1,5,65536\n"), "2: zoom is not a whole number from 0 to 65535");
  EXPECT_EQ(error_of("frame,frame,timestamp_ns\n"), "1: column 'frame' is there twice");
  EXPECT_EQ(error_of("frame,timestamp_ns\n0,0,0\n"), "2: 3 fields; the header has 2");
  EXPECT_EQ(error_of("frame,timestamp_ns\n0,0\n\n"), "3: 1 fields; the header has 2");
  EXPECT_EQ(error_of("frame,timestamp_ns\n-1,0\n"), "2: frame is not a whole number from 0 to 999999999");
  EXPECT_EQ(error_of("frame,timestamp_ns\n1000000000,0\n"), "2: frame is not a whole number from 0 to 999999999");
  EXPECT_EQ(error_of("frame,timestamp_ns\n0,1.5\n"),
            "2: timestamp_ns is not a whole number from 0 to 4000000000000000000");
  EXPECT_EQ(error_of("frame,timestamp_ns\n0,-5\n"),
            "2: timestamp_ns is not a whole number from 0 to 4000000000000000000");
  EXPECT_EQ(error_of("frame,timestamp_ns\n1,0\n1,5\n"), "3: frame does not grow");
  EXPECT_EQ(error_of("frame,timestamp_ns\n1,5\n2,5\n"), "3: timestamp_ns does not grow");
  EXPECT_EQ(error_of("frame,timestamp_ns,pan_deg\n1,5,nan\n"), "2: pan_deg is not a number from -360 to 360");
  EXPECT_EQ(error_of("frame,timestamp_ns,tilt_deg\n1,5,361\n"), "2: tilt_deg is not a number from -360 to 360");
}

}  // namespace
}  // namespace ninedot
