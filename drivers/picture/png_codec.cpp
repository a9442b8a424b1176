// libpng reports errors with longjmp, which must not cross an object with a destructor: each function that calls setjmp
// holds plain values only, and whatever it needs afterwards sits in a structure of its caller.
#include "drivers/picture/png_codec.h"

#include <png.h>
#include <zlib.h>

#include <array>
#include <cerrno>
#include <csetjmp>
#include <cstring>
#include <new>

namespace ninedot {
namespace {

constexpr std::array<std::uint8_t, 8> kSignature{0x89, 'P', 'N', 'G', 0x0D, 0x0A, 0x1A, 0x0A};
/// libpng's limit for one ancillary chunk; ours carry none worth reading.
constexpr png_alloc_size_t kMaxChunk_bytes = 1U << 20U;

struct Input {
  const std::uint8_t* next;
  std::size_t left;
};

void read_bytes(png_structp png, png_bytep to, std::size_t count) {
  auto* const input = static_cast<Input*>(png_get_io_ptr(png));
  if (count > input->left) png_error(png, "truncated");
  std::memcpy(to, input->next, count);
  input->next += count;
  input->left -= count;
}

[[noreturn]] void on_error(png_structp png, png_const_charp) { png_longjmp(png, 1); }
void on_warning(png_structp, png_const_charp) {}

struct DecodeJob {
  Input input;
  PictureSize size;
  std::uint8_t* luma;
  std::uint8_t* rgb;  ///< where colour goes when the file has it
  bool is_colour = false;
  Error error{Errc::kFrameUnreadable, 0, "the PNG picture is truncated or damaged"};
};

/// Everything between the header and the last chunk. \return false: see job.error
bool decode_rows(png_structp png, png_infop info, DecodeJob& job) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;  // NOLINT(cert-err52-cpp): libpng knows no other way
  png_set_read_fn(png, &job.input, read_bytes);
  png_set_user_limits(png, kMaxPictureSide_px, kMaxPictureSide_px);
  png_set_chunk_malloc_max(png, kMaxChunk_bytes);
  png_read_info(png, info);
  if (png_get_bit_depth(png, info) == 16) {
    job.error.text = "the PNG picture has 16 bits per sample; 8 are read";
    return false;
  }
  if (static_cast<int>(png_get_image_width(png, info)) != job.size.width_px ||
      static_cast<int>(png_get_image_height(png, info)) != job.size.height_px) {
    job.error = Error{Errc::kFrameSize, 0, "the picture's size is not the camera's"};
    return false;
  }
  const png_byte colour_type = png_get_color_type(png, info);
  job.is_colour = (colour_type & PNG_COLOR_MASK_COLOR) != 0;
  if (colour_type == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png);
  if (!job.is_colour && png_get_bit_depth(png, info) < 8) png_set_expand_gray_1_2_4_to_8(png);
  png_set_strip_alpha(png);
  const int passes = png_set_interlace_handling(png);
  png_read_update_info(png, info);

  std::uint8_t* const pixels = job.is_colour ? job.rgb : job.luma;
  const std::size_t stride_bytes = static_cast<std::size_t>(job.size.width_px) * (job.is_colour ? 3 : 1);
  if (png_get_rowbytes(png, info) != stride_bytes) return false;
  for (int pass = 0; pass < passes; ++pass)
    for (int y = 0; y < job.size.height_px; ++y)
      png_read_row(png, pixels + static_cast<std::size_t>(y) * stride_bytes, nullptr);
  png_read_end(png, nullptr);
  return true;
}

struct EncodeJob {
  const std::uint8_t* pixels;
  std::ptrdiff_t stride_bytes;
  PictureSize size;
  int channels;
  std::vector<std::uint8_t>* file;
};

void write_bytes(png_structp png, png_bytep from, std::size_t count) {
  auto* const file = static_cast<std::vector<std::uint8_t>*>(png_get_io_ptr(png));
  bool grown = true;
  try {
    file->insert(file->end(), from, from + count);
  } catch (const std::bad_alloc&) {
    grown = false;
  }
  if (!grown) png_error(png, "memory");
}
void flush_nothing(png_structp) {}

bool encode_rows(png_structp png, png_infop info, const EncodeJob& job) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;  // NOLINT(cert-err52-cpp)
  png_set_write_fn(png, job.file, write_bytes, flush_nothing);
  // Recording must keep up with the camera. On noisy pictures of 640 x 480 px (tests/recordings/approach, one x86-64
  // core) this takes 3.3 ms and 163 kB per frame; libpng's defaults take 23 ms and 174 kB.
  png_set_compression_strategy(png, Z_RLE);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_UP);
  png_set_IHDR(png, info, static_cast<png_uint_32>(job.size.width_px), static_cast<png_uint_32>(job.size.height_px), 8,
               job.channels == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  for (int y = 0; y < job.size.height_px; ++y) png_write_row(png, job.pixels + y * job.stride_bytes);
  png_write_end(png, info);
  return true;
}

std::uint32_t big_endian_32(const std::uint8_t* p) noexcept {
  return (std::uint32_t{p[0]} << 24U) | (std::uint32_t{p[1]} << 16U) | (std::uint32_t{p[2]} << 8U) | p[3];
}

}  // namespace

bool is_png(std::span<const std::uint8_t> file) noexcept {
  return file.size() >= kSignature.size() && std::memcmp(file.data(), kSignature.data(), kSignature.size()) == 0;
}

Result<PictureSize> read_png_size(std::span<const std::uint8_t> file) noexcept {
  // Signature (8), length and type of the first chunk (8), which is IHDR: width (4), height (4). PNG
  // specification, 11.2.2.
  if (file.size() < 24 || std::memcmp(file.data() + 12, "IHDR", 4) != 0)
    return fail(Errc::kFrameUnreadable, "the PNG picture is truncated or damaged");
  const std::uint32_t width = big_endian_32(file.data() + 16);
  const std::uint32_t height = big_endian_32(file.data() + 20);
  if (width == 0 || height == 0 || width > kMaxPictureSide_px || height > kMaxPictureSide_px)
    return fail(Errc::kFrameUnreadable, "the PNG picture's sides are not between 1 and 8192 px");
  return PictureSize{static_cast<int>(width), static_cast<int>(height)};
}

Result<bool> decode_png(std::span<const std::uint8_t> file, PictureSize size, std::span<std::uint8_t> luma,
                        std::span<std::uint8_t> rgb) noexcept {
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, on_error, on_warning);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  DecodeJob job{Input{file.data(), file.size()}, size, luma.data(), rgb.data()};
  const bool decoded = info != nullptr && decode_rows(png, info, job);
  png_destroy_read_struct(&png, &info, nullptr);
  if (!decoded) return tl::unexpected<Error>(job.error);
  return job.is_colour;
}

Result<std::size_t> encode_png(const std::uint8_t* pixels, std::ptrdiff_t stride_bytes, PictureSize size, int channels,
                               std::vector<std::uint8_t>& file) {
  file.clear();
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, on_error, on_warning);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  const bool encoded =
      info != nullptr && encode_rows(png, info, EncodeJob{pixels, stride_bytes, size, channels, &file});
  png_destroy_write_struct(&png, &info);
  if (!encoded) return fail(Errc::kIo, "the picture could not be encoded as PNG", ENOMEM);
  return file.size();
}

}  // namespace ninedot
