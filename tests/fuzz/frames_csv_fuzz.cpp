// What parses must read back to the same rows when it is written again.
#include "base/contract.h"
#include "proto/frames_csv.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t count) {
  using namespace ninedot;
  const auto rows = parse_frames_csv({reinterpret_cast<const char*>(bytes), count});
  if (!rows) {
    EXPECTS(rows.error().line >= 1 && !rows.error().what.empty());
    return 0;
  }
  std::string text(kFramesCsvHeader);
  for (const FramesCsvRow& row : *rows) text += format_frames_csv_row(row);
  const auto again = parse_frames_csv(text);
  EXPECTS(again && again->size() == rows->size());
  for (std::size_t i = 0; i < rows->size(); ++i) {
    const FramesCsvRow& a = (*rows)[i];
    const FramesCsvRow& b = (*again)[i];
    EXPECTS(a.frame == b.frame && a.timestamp_ns == b.timestamp_ns && a.pan_deg == b.pan_deg &&
            a.tilt_deg == b.tilt_deg);
  }
  return 0;
}
