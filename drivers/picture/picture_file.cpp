// Tells the kind of a picture from its first bytes and hands it to the codec; JPEG is short enough to live here.
#include "drivers/picture/picture_file.h"

#include <turbojpeg.h>

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

}  // namespace

PictureDecoder::PictureDecoder(PictureSize size)
    : size_(size),
      scratch_rgb_(std::make_unique_for_overwrite<std::uint8_t[]>(3 * size.pixel_count())),
      jpeg_(tjInitDecompress()) {}

PictureDecoder::~PictureDecoder() {
  if (jpeg_ != nullptr) tjDestroy(jpeg_);
}

Result<PictureSize> PictureDecoder::decode(std::span<const std::uint8_t> file, std::span<std::uint8_t> luma,
                                           std::span<std::uint8_t> rgb) noexcept {
  EXPECTS(luma.size() == size_.pixel_count());
  EXPECTS(rgb.empty() || rgb.size() == 3 * size_.pixel_count());
  if (is_png(file)) return decode_png(file, size_, luma, rgb, scratch_rgb_.get());
  if (is_pnm(file)) return decode_pnm(file, size_, luma, rgb);
  if (is_jpeg(file)) {
    const Result<PictureSize> decoded = decode_jpeg(jpeg_, file, size_, luma, rgb);
    if (!decoded) {  // turbojpeg 2.1 refuses every later picture after some damaged ones: start anew
      if (jpeg_ != nullptr) tjDestroy(jpeg_);
      jpeg_ = tjInitDecompress();
    }
    return decoded;
  }
  return fail(Errc::kFrameUnreadable, file.empty() ? "the file is empty" : "not a PNG, PGM, PPM or JPEG picture");
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
  return write_whole_file(path, file);
}

Result<std::size_t> write_png_grey(const std::string& path, const ImageView& luma) {
  std::vector<std::uint8_t> file;
  NINEDOT_TRY(const std::size_t bytes, encode_png_grey(luma, file));
  EXPECTS(bytes == file.size());
  return write_whole_file(path, file);
}

}  // namespace ninedot
