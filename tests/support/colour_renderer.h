#pragma once
/// Pictures of coloured landmarks: three exposures of the renderer, one for each of red, green and blue, read out
/// through a Bayer pattern and handed over as luma with chroma of half its resolution, as cameras do.
#include <array>
#include <cstdint>
#include <vector>

#include "image/chroma_view.h"
#include "tests/support/renderer.h"

namespace ninedot::test {

/// Linear: of light as a factor, of paint as a reflectance.
struct LinearRgb {
  double red = 1, green = 1, blue = 1;
};

/// Of a colour as screens have it (IEC 61966-2-1). \param red, green, blue  0..255
LinearRgb linear_of_srgb(int red, int green, int blue);

/// Of a black body of this temperature, as a camera sees it that is balanced for another; green is 1. Planck's law at
/// 610, 545 and 465 nm, where the sensitivities of cameras have their middles.
LinearRgb light_of_kelvin(double kelvin, double balanced_for_kelvin = 5000);

struct ColourScene {
  Scene scene;                   ///< its first sheet is painted with:
  std::vector<LinearRgb> discs;  ///< colours of its discs, in their order
  LinearRgb paper{0.90, 0.90, 0.90};
  double fade = 0;  ///< share of paper that shows through all discs, 0..1
  LinearRgb light;  ///< times the scene's
};

enum class ChromaLayout : std::uint8_t { k444, k422, k420 };

/// Owns its pixels.
struct ColourPicture {
  Picture luma;
  std::vector<std::uint8_t> chroma_bytes;  ///< Cb and Cr in turn, as NV12 has them
  int chroma_width = 0, chroma_height = 0;

  /// Valid while the picture lives and is not assigned to.
  ChromaView chroma() const {
    return {chroma_bytes.data(), chroma_bytes.data() + 1, chroma_width, chroma_height, 2, 2 * chroma_width};
  }
};

/// Of red, green and blue.
using ColourExposure = std::array<Exposure, 3>;

/// Every pixel measures one of the colours (RGGB) with the sensor's noise; the others are means of its neighbours'.
/// Then tone curve, ITU-R BT.601 in its full range, mean of each block of chroma, eight bits. The same seed gives the
/// same picture. \param exposure  of even width and height (contract)
ColourPicture read_out(const ColourExposure& exposure, const Sensor& sensor, ChromaLayout layout, std::uint64_t seed);

/// The scene's exposure, read out. \param scene  of even width and height (contract)
ColourPicture render_colour(const ColourScene& scene, ChromaLayout layout, std::uint64_t seed);

}  // namespace ninedot::test
