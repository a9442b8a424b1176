#pragma once
/// YUV4MPEG2 (.y4m) files: 8-bit mono, 4:2:0, 4:2:2 and 4:4:4, progressive. yuv4mpeg(5) of the mjpegtools is the
/// specification. Luma and chroma are taken as they are; most writers use 16..235 and 16..240 of the 256 levels.
#include <cstdint>
#include <span>
#include <string_view>

#include "drivers/picture/picture_file.h"

namespace ninedot {

/// A stream header or frame header is at most this long, its line feed included.
/// The specification names no limit; its fields with their longest values take 60 bytes, the rest is for comments.
inline constexpr std::size_t kMaxY4mHeader_bytes = 512;

struct Y4mHeader {
  PictureSize size;
  double rate_hz = 0;            ///< frames per second; 0 = the file does not say
  std::size_t header_bytes = 0;  ///< of the stream header, line feed included
  PictureSize chroma_size;       ///< of the Cb and of the Cr plane after each luma plane; 0 x 0: mono

  std::size_t frame_bytes() const noexcept { return size.pixel_count() + 2 * chroma_size.pixel_count(); }
};

/// \param start  the file's beginning, kMaxY4mHeader_bytes of it or all
/// \error kFrameUnreadable, its text says which part is wrong
Result<Y4mHeader> parse_y4m_header(std::span<const std::uint8_t> start) noexcept;

/// Length of a frame header ("FRAME" ... line feed). \error kFrameUnreadable
Result<std::size_t> parse_y4m_frame_header(std::span<const std::uint8_t> start) noexcept;

}  // namespace ninedot
