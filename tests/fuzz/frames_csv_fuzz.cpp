/// Whatever frames.csv holds: it is refused with a line number, or its rows read back from their own text.
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/contract.h"
#include "proto/frames_csv.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  using namespace ninedot;
  const auto rows = parse_frames_csv(std::string_view(reinterpret_cast<const char*>(bytes), size));
  if (!rows) {
    EXPECTS(rows.error().line >= 0 && !rows.error().what.empty());
    return 0;
  }
  std::string text(kFramesCsvHeader);
  for (const FramesCsvRow& row : *rows) text += format_frames_csv_row(row);
  const auto again = parse_frames_csv(text);
  EXPECTS(again.has_value() && again->size() == rows->size());
  return 0;
}
