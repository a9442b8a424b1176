#include "drivers/picture/pnm_codec.h"

#include <cstring>

namespace ninedot {
namespace {

constexpr bool is_space(std::uint8_t c) noexcept {
  return c == ' ' || c == '\t' || c == '\n' || c == '\v' || c == '\f' || c == '\r';
}

/// The next decimal number of the header, after white space and comments (# to the end of the line).
/// \return -1: none, or beyond 99999
int next_number(std::span<const std::uint8_t> file, std::size_t& at) noexcept {
  while (at < file.size() && (is_space(file[at]) || file[at] == '#')) {
    if (file[at] == '#')
      while (at < file.size() && file[at] != '\n') ++at;
    else
      ++at;
  }
  int number = 0;
  const std::size_t first_digit = at;
  for (; at < file.size() && file[at] >= '0' && file[at] <= '9'; ++at) {
    if (at - first_digit == 5) return -1;
    number = 10 * number + (file[at] - '0');
  }
  return at == first_digit ? -1 : number;
}

}  // namespace

bool is_pnm(std::span<const std::uint8_t> file) noexcept {
  return file.size() >= 3 && file[0] == 'P' && (file[1] == '5' || file[1] == '6') &&
         (is_space(file[2]) || file[2] == '#');
}

Result<PnmHeader> read_pnm_header(std::span<const std::uint8_t> file) noexcept {
  if (!is_pnm(file)) return fail(Errc::kFrameUnreadable, "not a binary PGM (P5) or PPM (P6) picture");
  PnmHeader header;
  header.channels = file[1] == '6' ? 3 : 1;
  std::size_t at = 2;
  header.size.width_px = next_number(file, at);
  header.size.height_px = next_number(file, at);
  const int max_value = next_number(file, at);
  if (max_value < 0 || at >= file.size() || !is_space(file[at]))
    return fail(Errc::kFrameUnreadable, "the PGM or PPM picture's header is truncated or damaged");
  if (header.size.width_px < 1 || header.size.height_px < 1 || header.size.width_px > kMaxPictureSide_px ||
      header.size.height_px > kMaxPictureSide_px)
    return fail(Errc::kFrameUnreadable, "the PGM or PPM picture's sides are not between 1 and 8192 px");
  if (max_value != 255)
    return fail(Errc::kFrameUnreadable, "the PGM or PPM picture's maximum is not 255; 8 bits are read");
  header.pixels_at = at + 1;
  return header;
}

Result<bool> decode_pnm(std::span<const std::uint8_t> file, PictureSize size, std::span<std::uint8_t> luma,
                        std::span<std::uint8_t> rgb) noexcept {
  const Result<PnmHeader> header = read_pnm_header(file);
  if (!header) return tl::unexpected<Error>(header.error());
  if (header->size != size) return fail(Errc::kFrameSize, "the picture's size is not the camera's");
  const std::size_t count = size.pixel_count();
  const std::size_t channels = static_cast<std::size_t>(header->channels);
  if (file.size() - header->pixels_at < count * channels)
    return fail(Errc::kFrameUnreadable, "the PGM or PPM picture is truncated");

  const std::uint8_t* const samples = file.data() + header->pixels_at;
  std::memcpy(channels == 1 ? luma.data() : rgb.data(), samples, count * channels);
  return channels == 3;
}

}  // namespace ninedot
