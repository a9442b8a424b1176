#include "drivers/picture/picture_file.h"

#include <gtest/gtest.h>
#include <png.h>
#include <turbojpeg.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace ninedot {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes bytes_of(const std::string& text) { return Bytes(text.begin(), text.end()); }

Bytes file_bytes(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return Bytes(std::istreambuf_iterator<char>(stream), {});
}

struct Decoded {
  Result<PictureSize> result;
  Bytes luma, rgb;
};

Decoded decode(const Bytes& file, PictureSize size, bool want_rgb = false) {
  PictureDecoder decoder(size);
  Decoded decoded{PictureSize{}, Bytes(size.pixel_count(), 0xCD), Bytes(want_rgb ? 3 * size.pixel_count() : 0, 0xCD)};
  decoded.result = decoder.decode(file, decoded.luma, decoded.rgb);
  return decoded;
}

/// A PNG made by libpng's simplified writer, a way that the code under test does not use.
Bytes png_file(std::uint32_t format, const Bytes& pixels, PictureSize size) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(size.width_px);
  image.height = static_cast<png_uint_32>(size.height_px);
  image.format = format;
  png_alloc_size_t bytes = 0;
  EXPECT_NE(png_image_write_to_memory(&image, nullptr, &bytes, 0, pixels.data(), 0, nullptr), 0);
  Bytes file(bytes);
  EXPECT_NE(png_image_write_to_memory(&image, file.data(), &bytes, 0, pixels.data(), 0, nullptr), 0);
  file.resize(bytes);
  return file;
}

Bytes jpeg_file(const Bytes& rgb, PictureSize size, TJSAMP sampling = TJSAMP_444) {
  const tjhandle jpeg = tjInitCompress();
  unsigned char* data = nullptr;
  unsigned long count = 0;
  EXPECT_EQ(tjCompress2(jpeg, rgb.data(), size.width_px, 0, size.height_px, TJPF_RGB, &data, &count, sampling, 100, 0),
            0);
  Bytes file(data, data + count);
  tjFree(data);
  tjDestroy(jpeg);
  return file;
}

constexpr PictureSize kSmall{16, 8};

Bytes ramp_rgb() {
  Bytes rgb(3 * kSmall.pixel_count());
  for (std::size_t i = 0; i < rgb.size(); ++i) rgb[i] = static_cast<std::uint8_t>(i * 5 / 8);
  return rgb;
}

TEST(PictureDecoder, ReadsAllKindsOfPng) {
  const Bytes rgb = ramp_rgb();
  Bytes rgba, grey;
  for (std::size_t i = 0; i < kSmall.pixel_count(); ++i) {
    for (std::size_t channel = 0; channel < 3; ++channel) rgba.push_back(rgb[3 * i + channel]);
    rgba.push_back(static_cast<std::uint8_t>(i));
    grey.push_back(luma_from_rgb(rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]));
  }
  const Decoded from_grey = decode(png_file(PNG_FORMAT_GRAY, grey, kSmall), kSmall, true);
  ASSERT_TRUE(from_grey.result);
  EXPECT_EQ(from_grey.luma, grey);
  EXPECT_EQ(from_grey.rgb[4], grey[1]);
  for (const Bytes& file : {png_file(PNG_FORMAT_RGB, rgb, kSmall), png_file(PNG_FORMAT_RGBA, rgba, kSmall)}) {
    const Decoded colour = decode(file, kSmall, true);
    ASSERT_TRUE(colour.result);
    EXPECT_EQ(colour.luma, grey);
    EXPECT_EQ(colour.rgb, rgb);
    EXPECT_EQ(decode(file, kSmall).luma, grey);
  }
}

TEST(PictureDecoder, ReadsPalettePictures) {
  png_image image{};
  image.version = PNG_IMAGE_VERSION;
  image.width = 2, image.height = 1;
  image.format = PNG_FORMAT_RGB_COLORMAP;
  image.colormap_entries = 2;
  const Bytes palette{200, 100, 50, 0, 0, 255}, indices{1, 0};
  Bytes file(1000);
  png_alloc_size_t bytes = file.size();
  ASSERT_NE(png_image_write_to_memory(&image, file.data(), &bytes, 0, indices.data(), 0, palette.data()), 0);
  file.resize(bytes);
  const Decoded decoded = decode(file, {2, 1}, true);
  ASSERT_TRUE(decoded.result);
  EXPECT_EQ(decoded.rgb, (Bytes{0, 0, 255, 200, 100, 50}));
  EXPECT_EQ(decoded.luma[1], luma_from_rgb(200, 100, 50));
}

TEST(PictureDecoder, RefusesPngWithSixteenBits) {
  const std::vector<std::uint16_t> pixels(kSmall.pixel_count(), 1000);
  Bytes raw(pixels.size() * 2);
  std::memcpy(raw.data(), pixels.data(), raw.size());
  const Decoded decoded = decode(png_file(PNG_FORMAT_LINEAR_Y, raw, kSmall), kSmall);
  ASSERT_FALSE(decoded.result);
  EXPECT_EQ(decoded.result.error().code, Errc::kFrameUnreadable);
  EXPECT_NE(std::string(decoded.result.error().text).find("16 bits"), std::string::npos);
}

TEST(PictureDecoder, ReadsPgmAndPpmWithComments) {
  const Decoded grey = decode(bytes_of("P5\n# made by hand\n2 1 # two\n255\nab"), {2, 1}, true);
  ASSERT_TRUE(grey.result);
  EXPECT_EQ(grey.luma, bytes_of("ab"));
  EXPECT_EQ(grey.rgb, bytes_of("aaabbb"));
  const Decoded colour = decode(bytes_of("P6 1 1 255\nRGB"), {1, 1}, true);
  ASSERT_TRUE(colour.result);
  EXPECT_EQ(colour.luma[0], luma_from_rgb('R', 'G', 'B'));
  EXPECT_EQ(colour.rgb, bytes_of("RGB"));
}

TEST(PictureDecoder, RefusesDamagedPnm) {
  for (const char* const text :
       {"P5", "P5 2 1 255", "P5 2 1 255\na", "P5 2 1 65535\nabcd", "P5 2 1 15\nab", "P5 0 1 255\n", "P5 2 9999 255\nab",
        "P5 2 123456 255\nab", "P4 2 1\nab", "P5 -2 1 255\nab", ""}) {
    const Decoded decoded = decode(bytes_of(text), {2, 1});
    ASSERT_FALSE(decoded.result) << text;
    EXPECT_EQ(decoded.result.error().code, Errc::kFrameUnreadable) << text;
    EXPECT_FALSE(read_picture_size(bytes_of(text)) && std::string(text).size() < 10) << text;
  }
}

TEST(PictureDecoder, ReadsJpegLumaWithinAFewLevels) {
  const Bytes rgb = ramp_rgb();
  const Decoded decoded = decode(jpeg_file(rgb, kSmall), kSmall, true);
  ASSERT_TRUE(decoded.result);
  for (std::size_t i = 0; i < kSmall.pixel_count(); ++i)
    EXPECT_NEAR(decoded.luma[i], luma_from_rgb(rgb[3 * i], rgb[3 * i + 1], rgb[3 * i + 2]), 4) << i;
}

struct WithChroma {
  Result<ChromaView> result;
  Bytes luma, chroma;
};

WithChroma decode_with_chroma(const Bytes& file, PictureSize size) {
  PictureDecoder decoder(size);
  WithChroma decoded{ChromaView{}, Bytes(size.pixel_count(), 0xCD), Bytes(2 * size.pixel_count(), 0xCD)};
  decoded.result = decoder.decode_with_chroma(file, decoded.luma, decoded.chroma);
  return decoded;
}

TEST(PictureDecoder, GivesTheColourOfEveryPixelOfAPngOrPpmBesideTheSameLuma) {
  const Bytes rgb = ramp_rgb();
  Bytes ppm = bytes_of("P6 16 8 255\n");
  ppm.insert(ppm.end(), rgb.begin(), rgb.end());
  for (const Bytes& file : {png_file(PNG_FORMAT_RGB, rgb, kSmall), ppm}) {
    const WithChroma decoded = decode_with_chroma(file, kSmall);
    ASSERT_TRUE(decoded.result);
    EXPECT_EQ(decoded.luma, decode(file, kSmall).luma);
    ASSERT_EQ(decoded.result->width, 16);
    ASSERT_EQ(decoded.result->height, 8);
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 16; ++x) {
        const std::uint8_t* const pixel = &rgb[static_cast<std::size_t>(3 * (16 * y + x))];
        ASSERT_EQ(decoded.result->cb_at(x, y), cb_from_rgb(pixel[0], pixel[1], pixel[2]));
        ASSERT_EQ(decoded.result->cr_at(x, y), cr_from_rgb(pixel[0], pixel[1], pixel[2]));
      }
  }
}

TEST(PictureDecoder, GivesNoColourOfAGreyPicture) {
  const Bytes grey(kSmall.pixel_count(), 77);
  const WithChroma decoded = decode_with_chroma(png_file(PNG_FORMAT_GRAY, grey, kSmall), kSmall);
  ASSERT_TRUE(decoded.result);
  EXPECT_TRUE(decoded.result->empty());
  EXPECT_EQ(decoded.luma, grey);
  const Bytes jpeg = jpeg_file(Bytes(3 * kSmall.pixel_count(), 77), kSmall, TJSAMP_GRAY);
  const WithChroma from_jpeg = decode_with_chroma(jpeg, kSmall);
  ASSERT_TRUE(from_jpeg.result);
  EXPECT_TRUE(from_jpeg.result->empty());
  EXPECT_EQ(from_jpeg.luma, decode(jpeg, kSmall).luma);
}

TEST(PictureDecoder, GivesAJpegsOwnColourAtAllSamplingsAndSizes) {
  for (const TJSAMP sampling : {TJSAMP_444, TJSAMP_422, TJSAMP_420, TJSAMP_440, TJSAMP_411})
    for (int width = 1; width < 20; ++width)
      for (int height = 1; height < 20; height += 1 + height / 5) {
        const PictureSize size{width, height};
        Bytes rgb(3 * size.pixel_count());
        for (std::size_t i = 0; i < size.pixel_count(); ++i) {
          rgb[3 * i] = 200;
          rgb[3 * i + 1] = static_cast<std::uint8_t>(60 + i % 7);  // the luma has something to get wrong
          rgb[3 * i + 2] = 30;
        }
        const Bytes file = jpeg_file(rgb, size, sampling);
        const WithChroma decoded = decode_with_chroma(file, size);
        ASSERT_TRUE(decoded.result);
        ASSERT_EQ(decoded.luma, decode(file, size).luma) << sampling << ' ' << width << 'x' << height;
        const ChromaView& chroma = *decoded.result;
        ASSERT_LE(chroma.width, width);
        ASSERT_LE(chroma.height, height);
        for (int y = 0; y < chroma.height; ++y)
          for (int x = 0; x < chroma.width; ++x) {
            ASSERT_NEAR(chroma.cb_at(x, y), cb_from_rgb(200, 63, 30), 4);
            ASSERT_NEAR(chroma.cr_at(x, y), cr_from_rgb(200, 63, 30), 4);
          }
      }
}

TEST(PictureDecoder, RefusesTheSamePicturesWithTheColourAsWithout) {
  const Bytes whole = jpeg_file(ramp_rgb(), kSmall, TJSAMP_420);
  for (std::size_t length = 0; length < whole.size(); ++length) {
    const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
    EXPECT_EQ(decode_with_chroma(cut, kSmall).result.has_value(), decode(cut, kSmall).result.has_value()) << length;
  }
  EXPECT_EQ(decode_with_chroma(whole, {15, 8}).result.error().code, Errc::kFrameSize);
}

TEST(PictureDecoder, TellsAnotherSizeFromADamagedPicture) {
  const Bytes pixels(kSmall.pixel_count(), 7);
  for (const Bytes& file :
       {png_file(PNG_FORMAT_GRAY, pixels, kSmall), jpeg_file(ramp_rgb(), kSmall), bytes_of("P5 2 1 255\nab")}) {
    const Decoded decoded = decode(file, {17, 8});
    ASSERT_FALSE(decoded.result);
    EXPECT_EQ(decoded.result.error().code, Errc::kFrameSize);
  }
}

TEST(PictureDecoder, RefusesEveryTruncationOfARealPng) {
  const Bytes file = file_bytes(std::string(NINEDOT_SOURCE_DIR) + "/tests/recordings/positions/frames/000001.png");
  ASSERT_GT(file.size(), 100000U);
  PictureDecoder decoder({640, 480});
  Bytes luma(640 * 480);
  ASSERT_TRUE(decoder.decode(file, luma));
  std::vector<std::size_t> lengths;
  for (std::size_t i = 0; i < 200; ++i) lengths.insert(lengths.end(), {i, file.size() - 1 - i});
  for (std::size_t length = 200; length < file.size(); length += 4999) lengths.push_back(length);
  for (const std::size_t length : lengths) {
    const Result<PictureSize> result = decoder.decode(std::span(file).first(length), luma);
    ASSERT_FALSE(result) << length;
    ASSERT_EQ(result.error().code, Errc::kFrameUnreadable) << length;
  }
  EXPECT_TRUE(decoder.decode(file, luma)) << "a damaged picture spoilt the decoder";
}

TEST(PictureDecoder, RefusesEveryTruncationOfAJpeg) {
  const Bytes file = jpeg_file(ramp_rgb(), kSmall);
  PictureDecoder decoder(kSmall);
  Bytes luma(kSmall.pixel_count());
  for (std::size_t length = 0; length < file.size(); ++length)
    ASSERT_FALSE(decoder.decode(std::span(file).first(length), luma)) << length << " of " << file.size();
  EXPECT_TRUE(decoder.decode(file, luma));
}

TEST(PictureDecoder, FindsFlippedBitsInAPngByItsChecksums) {
  Bytes file = file_bytes(std::string(NINEDOT_SOURCE_DIR) + "/tests/recordings/positions/frames/000001.png");
  file[file.size() / 2] ^= 0x10U;
  EXPECT_FALSE(decode(file, {640, 480}).result);
}

TEST(PictureEncoder, WritesPngThatReadsBackToTheSamePixels) {
  Bytes grey(kSmall.pixel_count() + 8 * 4);
  for (std::size_t i = 0; i < grey.size(); ++i) grey[i] = static_cast<std::uint8_t>(i * 37);
  const ImageView view{grey.data(), 16, 8, 20};  // with a stride
  Bytes file;
  ASSERT_TRUE(encode_png_grey(view, file));
  EXPECT_EQ(*read_picture_size(file), kSmall);
  const Decoded decoded = decode(file, kSmall);
  ASSERT_TRUE(decoded.result);
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 16; ++x) ASSERT_EQ(decoded.luma[static_cast<std::size_t>(y * 16 + x)], view.at(x, y));
  const Bytes rgb = ramp_rgb();
  ASSERT_TRUE(encode_png_rgb(rgb, kSmall, file));
  EXPECT_EQ(decode(file, kSmall, true).rgb, rgb);
}

TEST(PictureEncoder, LeavesNothingBehindWhenTheFileCantBeWritten) {
  const Bytes grey(kSmall.pixel_count());
  const ImageView view{grey.data(), 16, 8, 16};
  EXPECT_EQ(write_png_grey("/nonexistent/a.png", view).error().os_errno, ENOENT);
  const std::filesystem::path folder = testing::TempDir() + "ninedot_written";
  std::filesystem::create_directories(folder);
  ASSERT_TRUE(write_png_grey(folder / "a.png", view));
  EXPECT_TRUE(std::filesystem::exists(folder / "a.png"));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), std::filesystem::directory_iterator{}), 1);
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace ninedot
