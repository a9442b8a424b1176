#pragma once
/// What a picture says of the letters of a landmark's ring, K R G B, when its pose is known.
#include <array>
#include <cstddef>
#include <cstdint>

#include "colour/disc_picture.h"
#include "colour/ink_classes.h"
#include "geometry/camera_model.h"
#include "geometry/landmark.h"
#include "geometry/transform.h"
#include "image/chroma_view.h"
#include "image/image_view.h"
#include "image/noise.h"

namespace ninedot {

/// For each place of the ring, as the pose numbers it, and each of kInkLetters: the logarithm of its likelihood, that
/// of the likeliest letter taken off. All 0: nothing is known of the place (hidden, outside of the picture, too small).
struct DotColours {
  std::array<std::array<float, kInkCount>, kRingDotCount> log_likelihood{};
  /// Of any ink whose colour a coarse picture has lost (JPEG, dots of few pixels), on the same scale. [1]
  std::array<float, kRingDotCount> log_colourless{};
  bool has_colour = false;  ///< false: the picture is grey, or no dot can be read; then all are 0

  /// The likeliest letter of a place, for people; '?' where another one is likelier than 1 to 20.
  char letter(std::size_t place) const noexcept;
};

/// Reads colours beside the paper around each dot and the black of P9, so that the light's colour, shade, haze and
/// faded ink drop out; docs/method.md, "Colours". Memory: none but 20 kB of stack. Threads: const is safe.
class ColourReader {
 public:
  ColourReader(const CameraModel& camera, const LandmarkGeometry& landmark) noexcept
      : camera_(camera), landmark_(landmark) {}

  /// All eight places. \param chroma  that came with the luma; empty: grey \param T_camera_landmark  where P9 is seen
  /// \param noise  of the luma \param motion  of the sheet; lines that are shorter than a dot are not regarded
  DotColours read(const ImageView& luma, const ChromaView& chroma, const CameraFromLandmark& T_camera_landmark,
                  const PictureNoise& noise, const PictureMotion& motion = {}) const noexcept;

  /// Two opposite places, others with every frame, from fewer samples, for a sixth of the cost: what a landmark takes
  /// whose code is known and only to be watched (CodeReader::evidence_against). Of the others nothing is known. Dots of
  /// less than 2.8 px, or that draw lines, are read together or not at all: of them all eight.
  /// \param frame_number  any that goes up by one
  DotColours watch(const ImageView& luma, const ChromaView& chroma, const CameraFromLandmark& T_camera_landmark,
                   const PictureNoise& noise, std::uint64_t frame_number,
                   const PictureMotion& motion = {}) const noexcept;

 private:
  /// \param places  bit k: read place k
  DotColours read_places(const ImageView& luma, const ChromaView& chroma, const CameraFromLandmark& T_camera_landmark,
                         const PictureNoise& noise, const PictureMotion& motion, std::uint8_t places,
                         float most_blocks) const noexcept;

  CameraModel camera_;
  LandmarkGeometry landmark_;
};

}  // namespace ninedot
