#pragma once
/// JPEG pictures of frames, for people: libturbojpeg, straight from luma and chroma.
#include <cstdint>
#include <span>
#include <vector>

#include "base/result.h"
#include "image/chroma_view.h"
#include "image/image_view.h"

namespace ninedot {

/// Memory: grows to the first picture's size, then stays. Threads: one caller.
class JpegEncoder {
 public:
  JpegEncoder();
  ~JpegEncoder();
  JpegEncoder(const JpegEncoder&) = delete;
  JpegEncoder& operator=(const JpegEncoder&) = delete;

  /// Colour is kept at half the resolution each way (4:2:0), whatever the camera has.
  /// \param luma  not empty (contract) \param chroma  empty: a grey picture
  /// \param quality  1..100, libjpeg's
  /// \return  the file; valid until the next call
  /// \error kIo: libturbojpeg refused.
  Result<std::span<const std::uint8_t>> encode(const ImageView& luma, const ChromaView& chroma, int quality);

 private:
  void pad(const ImageView& luma);

  void* jpeg_ = nullptr;  ///< tjhandle, a void* in turbojpeg.h as well
  std::vector<std::uint8_t> file_, cb_, cr_, padded_;
};

}  // namespace ninedot
