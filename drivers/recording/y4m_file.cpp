#include "drivers/recording/y4m_file.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <optional>

namespace ninedot {
namespace {

constexpr std::string_view kMagic = "YUV4MPEG2";
constexpr std::string_view kFrameMagic = "FRAME";

/// The first line, without its line feed; nothing when it does not end within kMaxY4mHeader_bytes.
std::optional<std::string_view> first_line(std::span<const std::uint8_t> start) noexcept {
  const std::string_view text(reinterpret_cast<const char*>(start.data()), std::min(start.size(), kMaxY4mHeader_bytes));
  const std::size_t end = text.find('\n');
  if (end == std::string_view::npos) return std::nullopt;
  return text.substr(0, end);
}

int parse_side_px(std::string_view text) noexcept {
  int side_px = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), side_px);
  return error == std::errc{} && end == text.data() + text.size() && side_px <= kMaxPictureSide_px ? side_px : 0;
}

/// "35:1" or "30000:1001"; 0 = unknown ("0:0") or not a rate
double parse_rate_hz(std::string_view text) noexcept {
  std::uint32_t numerator = 0;
  std::uint32_t denominator = 0;
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, numerator);
  if (first.ec != std::errc{} || first.ptr == end || *first.ptr != ':') return 0;
  const auto second = std::from_chars(first.ptr + 1, end, denominator);
  if (second.ec != std::errc{} || second.ptr != end || denominator == 0) return 0;
  const double rate_hz = static_cast<double>(numerator) / static_cast<double>(denominator);
  return rate_hz >= 1e-3 && rate_hz <= 1e5 ? rate_hz : 0;
}

/// Of one chroma plane. Odd sides round up, as the format demands.
std::optional<PictureSize> chroma_size(std::string_view kind, PictureSize size) noexcept {
  const int half_width = (size.width_px + 1) / 2, half_height = (size.height_px + 1) / 2;
  if (kind == "mono") return PictureSize{};
  if (kind == "420" || kind == "420jpeg" || kind == "420mpeg2" || kind == "420paldv")
    return PictureSize{half_width, half_height};
  if (kind == "422") return PictureSize{half_width, size.height_px};
  if (kind == "444") return size;
  return std::nullopt;
}

}  // namespace

Result<Y4mHeader> parse_y4m_header(std::span<const std::uint8_t> start) noexcept {
  const std::optional<std::string_view> line = first_line(start);
  if (!line || !line->starts_with(kMagic) || (line->size() > kMagic.size() && (*line)[kMagic.size()] != ' '))
    return fail(Errc::kFrameUnreadable, "not a YUV4MPEG2 file, or its first line is damaged");
  Y4mHeader header;
  header.header_bytes = line->size() + 1;
  std::string_view kind = "420";
  std::string_view rest = line->substr(kMagic.size());
  while (!rest.empty()) {
    rest.remove_prefix(1);  // the blank
    const std::string_view field = rest.substr(0, rest.find(' '));
    rest.remove_prefix(field.size());
    if (field.empty()) continue;
    const std::string_view value = field.substr(1);
    switch (field[0]) {
      case 'W':
        header.size.width_px = parse_side_px(value);
        break;
      case 'H':
        header.size.height_px = parse_side_px(value);
        break;
      case 'F':
        header.rate_hz = parse_rate_hz(value);
        break;
      case 'C':
        kind = value;
        break;
      case 'I':
        if (value != "p" && value != "?")
          return fail(Errc::kFrameUnreadable, "the Y4M file is interlaced; record it progressive");
        break;
      default:
        break;  // aspect ratio and comments don't matter here
    }
  }
  if (header.size.width_px < 1 || header.size.height_px < 1)
    return fail(Errc::kFrameUnreadable, "the Y4M file's W or H is missing or not between 1 and 8192");
  const std::optional<PictureSize> chroma = chroma_size(kind, header.size);
  if (!chroma) return fail(Errc::kFrameUnreadable, "the Y4M file's C is none of mono, 420, 422, 444 with 8 bits");
  header.chroma_size = *chroma;
  return header;
}

Result<std::size_t> parse_y4m_frame_header(std::span<const std::uint8_t> start) noexcept {
  const std::optional<std::string_view> line = first_line(start);
  if (!line || !line->starts_with(kFrameMagic) ||
      (line->size() > kFrameMagic.size() && (*line)[kFrameMagic.size()] != ' '))
    return fail(Errc::kFrameUnreadable, "a frame of the Y4M file does not start with FRAME");
  return line->size() + 1;
}

}  // namespace ninedot
