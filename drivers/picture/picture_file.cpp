// Tells the kind of a picture from its first bytes and hands it to the codec; JPEG is short enough to live here.
#include "drivers/picture/picture_file.h"

#include <turbojpeg.h>

#include <cstring>

#include "base/contract.h"
#include "drivers/picture/png_codec.h"
#include "drivers/picture/pnm_codec.h"
#include "drivers/posix/whole_file.h"

namespace ninedot {
namespace {

constexpr const char* kDamagedJpeg = "the JPEG picture is truncated or damaged";

bool is_jpeg(std::span<const std::uint8_t> file) noexcept {
  return file.size() >= 3 && file[0] == 0xFF && file[1] == 0xD8 && file[2] == 0xFF;
}

Result<PictureSize> read_jpeg_size(tjhandle jpeg, std::span<const std::uint8_t> file) noexcept {
  PictureSize size;
  int subsampling = 0;
  int colour_space = 0;
  if (jpeg == nullptr || tjDecompressHeader3(jpeg, file.data(), static_cast<unsigned long>(file.size()), &size.width_px,
                                             &size.height_px, &subsampling, &colour_space) != 0)
    return fail(Errc::kFrameUnreadable, kDamagedJpeg);
  if (size.width_px < 1 || size.height_px < 1 || size.width_px > kMaxPictureSide_px ||
      size.height_px > kMaxPictureSide_px)
    return fail(Errc::kFrameUnreadable, "the JPEG picture's sides are not between 1 and 8192 px");
  return size;
}

/// A warning of the library (it fills up what is missing with grey) is an error here: a made-up picture is worse than
/// none.
bool decompress(tjhandle jpeg, std::span<const std::uint8_t> file, PictureSize size, TJPF format,
                std::uint8_t* to) noexcept {
  return tjDecompress2(jpeg, file.data(), static_cast<unsigned long>(file.size()), to, size.width_px, 0, size.height_px,
                       format, TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS) == 0;
}

Result<PictureSize> decode_jpeg(tjhandle jpeg, std::span<const std::uint8_t> file, PictureSize size,
                                std::span<std::uint8_t> luma, std::span<std::uint8_t> rgb) noexcept {
  const Result<PictureSize> in_file = read_jpeg_size(jpeg, file);
  if (!in_file) return in_file;
  if (*in_file != size) return fail(Errc::kFrameSize, "the picture's size is not the camera's");
  if (!decompress(jpeg, file, size, TJPF_GRAY, luma.data())) return fail(Errc::kFrameUnreadable, kDamagedJpeg);
  if (!rgb.empty() && !decompress(jpeg, file, size, TJPF_RGB, rgb.data()))
    return fail(Errc::kFrameUnreadable, kDamagedJpeg);
  return size;
}

/// A JPEG's planes are whole blocks of its subsampling, up to four pixels: this much longer on each side.
constexpr int kPlaneMargin_px = 3;

constexpr std::size_t scratch_bytes(PictureSize size) noexcept {
  return 3 * PictureSize{size.width_px + kPlaneMargin_px, size.height_px + kPlaneMargin_px}.pixel_count();
}

ChromaView full_size_view(std::span<const std::uint8_t> chroma, PictureSize size) noexcept {
  return {chroma.data(), chroma.data() + size.pixel_count(), size.width_px, size.height_px, 1, size.width_px};
}

Result<ChromaView> decode_jpeg_with_chroma(tjhandle jpeg, std::span<const std::uint8_t> file, PictureSize size,
                                           std::span<std::uint8_t> luma, std::span<std::uint8_t> chroma,
                                           std::span<std::uint8_t> scratch) noexcept {
  PictureSize in_file;
  int sampling = 0, space = 0;
  const bool is_jpeg =
      jpeg != nullptr && tjDecompressHeader3(jpeg, file.data(), static_cast<unsigned long>(file.size()),
                                             &in_file.width_px, &in_file.height_px, &sampling, &space) == 0;
  // Grey, and what stores no Cb and Cr.
  if (!is_jpeg || in_file != size || space != TJCS_YCbCr || sampling == TJSAMP_GRAY) {
    const bool has_rgb = is_jpeg && in_file == size && space == TJCS_RGB;
    const auto rgb = has_rgb ? scratch.first(3 * size.pixel_count()) : std::span<std::uint8_t>{};
    NINEDOT_TRY([[maybe_unused]] const PictureSize decoded, decode_jpeg(jpeg, file, size, luma, rgb));
    if (!has_rgb) return ChromaView{};
    chroma_from_rgb(rgb, chroma.data(), chroma.data() + size.pixel_count());
    return full_size_view(chroma, size);
  }
  const int luma_width = tjPlaneWidth(0, size.width_px, sampling),
            luma_height = tjPlaneHeight(0, size.height_px, sampling);
  const int width = tjPlaneWidth(1, size.width_px, sampling), height = tjPlaneHeight(1, size.height_px, sampling);
  const bool is_padded = luma_width != size.width_px || luma_height != size.height_px;
  std::uint8_t* const cr = chroma.data() + static_cast<std::ptrdiff_t>(width) * height;
  unsigned char* planes[3] = {is_padded ? scratch.data() : luma.data(), chroma.data(), cr};
  int strides[3] = {luma_width, width, width};
  if (tjDecompressToYUVPlanes(jpeg, file.data(), static_cast<unsigned long>(file.size()), planes, size.width_px,
                              strides, size.height_px, TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS) != 0)
    return fail(Errc::kFrameUnreadable, kDamagedJpeg);
  if (is_padded)
    for (int y = 0; y < size.height_px; ++y)
      std::memcpy(luma.data() + static_cast<std::ptrdiff_t>(y) * size.width_px,
                  scratch.data() + static_cast<std::ptrdiff_t>(y) * luma_width,
                  static_cast<std::size_t>(size.width_px));
  return ChromaView{chroma.data(), cr, width, height, 1, width};
}

/// PNG and PNM: into `luma` where the picture is grey, else into `rgb`. \return  whether it has colour
Result<bool> decode_samples(std::span<const std::uint8_t> file, PictureSize size, std::span<std::uint8_t> luma,
                            std::span<std::uint8_t> rgb) noexcept {
  if (is_png(file)) return decode_png(file, size, luma, rgb);
  if (is_pnm(file)) return decode_pnm(file, size, luma, rgb);
  return fail(Errc::kFrameUnreadable, file.empty() ? "the file is empty" : "not a PNG, PGM, PPM or JPEG picture");
}

void fill_luma(std::span<const std::uint8_t> rgb, std::span<std::uint8_t> luma) noexcept {
  for (std::size_t i = 0; i < luma.size(); ++i) luma[i] = luma_from_rgb(rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]);
}

}  // namespace

PictureDecoder::PictureDecoder(PictureSize size)
    : size_(size),
      scratch_(std::make_unique_for_overwrite<std::uint8_t[]>(scratch_bytes(size))),
      jpeg_(tjInitDecompress()) {}

PictureDecoder::~PictureDecoder() {
  if (jpeg_ != nullptr) tjDestroy(jpeg_);
}

/// turbojpeg 2.1 refuses every later picture after some damaged ones: start anew.
void PictureDecoder::recover_jpeg() noexcept {
  if (jpeg_ != nullptr) tjDestroy(jpeg_);
  jpeg_ = tjInitDecompress();
}

Result<PictureSize> PictureDecoder::decode(std::span<const std::uint8_t> file, std::span<std::uint8_t> luma,
                                           std::span<std::uint8_t> rgb) noexcept {
  EXPECTS(luma.size() == size_.pixel_count());
  EXPECTS(rgb.empty() || rgb.size() == 3 * size_.pixel_count());
  if (is_jpeg(file)) {
    const Result<PictureSize> decoded = decode_jpeg(jpeg_, file, size_, luma, rgb);
    if (!decoded) recover_jpeg();
    return decoded;
  }
  const auto colours = rgb.empty() ? std::span(scratch_.get(), 3 * luma.size()) : rgb;
  NINEDOT_TRY(const bool has_colour, decode_samples(file, size_, luma, colours));
  if (has_colour)
    fill_luma(colours, luma);
  else if (!rgb.empty())
    for (std::size_t i = 0; i < luma.size(); ++i) rgb[3 * i] = rgb[3 * i + 1] = rgb[3 * i + 2] = luma[i];
  return size_;
}

Result<ChromaView> PictureDecoder::decode_with_chroma(std::span<const std::uint8_t> file, std::span<std::uint8_t> luma,
                                                      std::span<std::uint8_t> chroma) noexcept {
  EXPECTS(luma.size() == size_.pixel_count() && chroma.size() == 2 * luma.size());
  if (is_jpeg(file)) {
    const Result<ChromaView> decoded =
        decode_jpeg_with_chroma(jpeg_, file, size_, luma, chroma, {scratch_.get(), scratch_bytes(size_)});
    if (!decoded) recover_jpeg();
    return decoded;
  }
  const auto rgb = std::span(scratch_.get(), 3 * luma.size());
  NINEDOT_TRY(const bool has_colour, decode_samples(file, size_, luma, rgb));
  if (!has_colour) return ChromaView{};
  fill_luma(rgb, luma);
  chroma_from_rgb(rgb, chroma.data(), chroma.data() + luma.size());
  return full_size_view(chroma, size_);
}

Result<PictureSize> read_picture_size(std::span<const std::uint8_t> file) noexcept {
  if (is_png(file)) return read_png_size(file);
  if (is_pnm(file)) {
    const Result<PnmHeader> header = read_pnm_header(file);
    if (!header) return tl::unexpected<Error>(header.error());
    return header->size;
  }
  if (is_jpeg(file)) {
    const tjhandle jpeg = tjInitDecompress();
    const Result<PictureSize> size = read_jpeg_size(jpeg, file);
    if (jpeg != nullptr) tjDestroy(jpeg);
    return size;
  }
  return fail(Errc::kFrameUnreadable, file.empty() ? "the file is empty" : "not a PNG, PGM, PPM or JPEG picture");
}

Result<std::size_t> encode_png_grey(const ImageView& luma, std::vector<std::uint8_t>& file) {
  return encode_png(luma.pixels, luma.stride_bytes, PictureSize{luma.width_px, luma.height_px}, 1, file);
}

Result<std::size_t> encode_png_rgb(std::span<const std::uint8_t> rgb, PictureSize size,
                                   std::vector<std::uint8_t>& file) {
  EXPECTS(rgb.size() == 3 * size.pixel_count());
  return encode_png(rgb.data(), 3 * static_cast<std::ptrdiff_t>(size.width_px), size, 3, file);
}

Result<std::size_t> write_png_rgb(const std::string& path, std::span<const std::uint8_t> rgb, PictureSize size) {
  std::vector<std::uint8_t> file;
  NINEDOT_TRY(const std::size_t bytes, encode_png_rgb(rgb, size, file));
  EXPECTS(bytes == file.size());
  return write_whole_file(path, file, Durability::kWhenConvenient);
}

Result<std::size_t> write_png_grey(const std::string& path, const ImageView& luma) {
  std::vector<std::uint8_t> file;
  NINEDOT_TRY(const std::size_t bytes, encode_png_grey(luma, file));
  EXPECTS(bytes == file.size());
  return write_whole_file(path, file, Durability::kWhenConvenient);
}

}  // namespace ninedot
