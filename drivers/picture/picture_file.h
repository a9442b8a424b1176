#pragma once
/// Picture files: PNG, PNM (PGM and PPM) and JPEG into memory that the caller owns, and PNG out again.
///
/// Luma and chroma of a colour picture: ITU-R BT.601 with the full range of levels (ycbcr.h); JPEG stores these very Y,
/// Cb and Cr, which are taken as they are. Alpha is ignored. No gamma correction: the grey levels are the file's own.
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "base/result.h"
#include "drivers/picture/ycbcr.h"
#include "image/chroma_view.h"
#include "image/image_view.h"

namespace ninedot {

/// Wider or higher pictures are refused: a damaged header must not ask for gigabytes. The largest sensors for such
/// boards have half of that (IMX477: 4056 px, its data sheet).
inline constexpr int kMaxPictureSide_px = 8192;

struct PictureSize {
  int width_px = 0;
  int height_px = 0;

  constexpr std::size_t pixel_count() const noexcept {
    return static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px);
  }
  friend bool operator==(const PictureSize&, const PictureSize&) = default;
};

/// Decodes one picture after the other.
/// Memory: the constructor allocates what is ours; libpng and libturbojpeg allocate inside their calls, so a thread
/// that must not allocate lets another one decode. Threads: one caller.
class PictureDecoder {
 public:
  /// \param size  the one size of all pictures to come
  explicit PictureDecoder(PictureSize size);
  ~PictureDecoder();
  PictureDecoder(const PictureDecoder&) = delete;
  PictureDecoder& operator=(const PictureDecoder&) = delete;

  /// \param file  the whole file; its kind is told from its first bytes
  /// \param luma  size.pixel_count() bytes, rows without gaps (contract); undefined after a failure
  /// \param rgb  three times that for R, G, B of each pixel, or empty when not wanted
  /// \error kFrameUnreadable: truncated, damaged, or not an 8-bit PNG, PNM or JPEG. kFrameSize: of another size.
  Result<PictureSize> decode(std::span<const std::uint8_t> file, std::span<std::uint8_t> luma,
                             std::span<std::uint8_t> rgb = {}) noexcept;

  /// The same luma, and the colour beside it: at every pixel of a PNG or PPM, at as many as a JPEG has it.
  /// \param chroma  2 * size.pixel_count() bytes (contract), where the view looks
  /// \return  empty: the picture is grey
  Result<ChromaView> decode_with_chroma(std::span<const std::uint8_t> file, std::span<std::uint8_t> luma,
                                        std::span<std::uint8_t> chroma) noexcept;

 private:
  void recover_jpeg() noexcept;

  PictureSize size_;
  std::unique_ptr<std::uint8_t[]> scratch_;  ///< R, G, B of a picture, or a padded plane of luma
  void* jpeg_ = nullptr;                     ///< tjhandle, a void* in turbojpeg.h as well
};

/// Size from the header alone.
/// \error kFrameUnreadable: no header that we know, or a side beyond kMaxPictureSide_px.
Result<PictureSize> read_picture_size(std::span<const std::uint8_t> file) noexcept;

/// A PNG file of 8-bit grey pixels, replacing the contents of `file` (whose capacity is reused).
/// \return  bytes of the file
/// \error kIo with ENOMEM: libpng could not allocate.
Result<std::size_t> encode_png_grey(const ImageView& luma, std::vector<std::uint8_t>& file);

/// The same for R, G, B of each pixel, rows without gaps. \param rgb  3 * size.pixel_count() bytes (contract)
/// \return  bytes of the file
Result<std::size_t> encode_png_rgb(std::span<const std::uint8_t> rgb, PictureSize size,
                                   std::vector<std::uint8_t>& file);

/// Writes an overlay (write_whole_file, Durability::kWhenConvenient). \return  bytes of the file
/// \error kIo with errno.
Result<std::size_t> write_png_rgb(const std::string& path, std::span<const std::uint8_t> rgb, PictureSize size);
/// The same for 8-bit grey. \return  bytes of the file
Result<std::size_t> write_png_grey(const std::string& path, const ImageView& luma);

}  // namespace ninedot
