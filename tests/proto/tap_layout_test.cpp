#include "proto/tap_layout.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include "proto/tap_document.h"

namespace ninedot {
namespace {

/// What readers in other languages rely on: written down once more, by hand. A change is another version.
TEST(TapLayout, OfVersion3IsThis) {
  EXPECT_EQ(kTapVersion, 3U);
  EXPECT_EQ(std::string(kTapMagic.begin(), kTapMagic.end()), std::string("NINETAP\0", 8));
  EXPECT_EQ(sizeof(TapHeader), 512U);
  EXPECT_EQ(offsetof(TapHeader, version), 8U);
  EXPECT_EQ(offsetof(TapHeader, segment_bytes), 16U);
  EXPECT_EQ(offsetof(TapHeader, frame_slots_offset), 24U);
  EXPECT_EQ(offsetof(TapHeader, pixels_offset), 40U);
  EXPECT_EQ(offsetof(TapHeader, service_slots_offset), 56U);
  EXPECT_EQ(offsetof(TapHeader, slot_count), 72U);
  EXPECT_EQ(offsetof(TapHeader, started_at_ns), 80U);
  EXPECT_EQ(offsetof(TapHeader, software), 88U);
  EXPECT_EQ(offsetof(TapHeader, width_px), 120U);
  EXPECT_EQ(offsetof(TapHeader, intrinsics_px), 136U);
  EXPECT_EQ(offsetof(TapHeader, ring_radius_mm), 232U);
  EXPECT_EQ(offsetof(TapHeader, newest_frame), 496U);
  EXPECT_EQ(offsetof(TapHeader, newest_service), 504U);
  EXPECT_EQ(sizeof(TapSlot), 64U);
  EXPECT_EQ(sizeof(TapPose), 104U);
  EXPECT_EQ(sizeof(TapPicture), 40U);
  EXPECT_EQ(sizeof(TapDot), 48U);
  EXPECT_EQ(sizeof(TapCandidate), 72U);
  EXPECT_EQ(sizeof(TapLandmark), 176U);
  EXPECT_EQ(offsetof(TapFrame, exposed_at_ns), 8U);
  EXPECT_EQ(offsetof(TapFrame, picture), 72U);
  EXPECT_EQ(offsetof(TapFrame, flags), 112U);
  EXPECT_EQ(offsetof(TapFrame, frames_processed), 136U);
  EXPECT_EQ(offsetof(TapFrame, landmark_count), 184U);
  EXPECT_EQ(offsetof(TapFrame, rms_px), 200U);
  EXPECT_EQ(offsetof(TapFrame, camera_in_landmark), 280U);
  EXPECT_EQ(offsetof(TapFrame, track), 592U);
  EXPECT_EQ(offsetof(TapFrame, dots), 728U);
  EXPECT_EQ(offsetof(TapFrame, landmarks), 1160U);
  EXPECT_EQ(offsetof(TapFrame, latency_bins), 3976U);
  EXPECT_EQ(offsetof(TapFrame, search), 4136U);
  EXPECT_EQ(sizeof(TapFrame), 9720U);
  EXPECT_EQ(sizeof(TapSpot), 20U);
  EXPECT_EQ(offsetof(TapSearch, spots_seen), 8U);
  EXPECT_EQ(offsetof(TapSearch, contrast_lsb), 16U);
  EXPECT_EQ(offsetof(TapSearch, dots), 32U);
  EXPECT_EQ(offsetof(TapSearch, spots), 464U);
  EXPECT_EQ(sizeof(TapClient), 88U);
  EXPECT_EQ(sizeof(TapLogLine), 192U);
  EXPECT_EQ(offsetof(TapService, registers), 40U);
  EXPECT_EQ(offsetof(TapService, clients), 424U);
  EXPECT_EQ(offsetof(TapService, log), 1832U);
  EXPECT_EQ(sizeof(TapService), 6440U);
}

/// No member is left out, and none overlaps another.
TEST(TapLayout, IsDocumentedToTheLastByte) {
  for (const TapStructure& structure : tap_structures()) {
    std::size_t end = 0;
    for (const TapField& field : structure.fields) {
      EXPECT_EQ(field.offset, end) << structure.name << ' ' << field.name;
      end = field.offset + field.size;
    }
    EXPECT_EQ(end, structure.size) << structure.name;
  }
}

TEST(TapLayout, StandsInTheDocumentAsItIs) {
  std::ifstream file(NINEDOT_SOURCE_DIR "/docs/tap.md");
  std::stringstream text;
  text << file.rdbuf();
  std::ofstream(NINEDOT_BINARY_DIR "/tap_layout.md") << tap_layout_markdown();
  EXPECT_NE(text.str().find(tap_layout_markdown()), std::string::npos)
      << "the tables of docs/tap.md are not these: " NINEDOT_BINARY_DIR "/tap_layout.md";
}

}  // namespace
}  // namespace ninedot
