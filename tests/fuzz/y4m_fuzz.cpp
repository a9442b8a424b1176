// The stream header, then frame header after frame header as the index walks them.
#include "base/contract.h"
#include "drivers/recording/y4m_file.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t count) {
  using namespace ninedot;
  const std::span<const std::uint8_t> file(bytes, count);
  const Result<Y4mHeader> header = parse_y4m_header(file);
  if (!header) return 0;
  EXPECTS(header->header_bytes <= count && header->frame_bytes() >= header->size.pixel_count());
  for (std::size_t at = header->header_bytes; at < count;) {
    const Result<std::size_t> frame_header = parse_y4m_frame_header(file.subspan(at));
    if (!frame_header) break;
    EXPECTS(*frame_header <= count - at);
    at += *frame_header + header->frame_bytes();
  }
  return 0;
}
