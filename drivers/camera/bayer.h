#pragma once
/// Luma and colour of what a colour sensor measured behind its mosaic of red, green and blue, where no image processor
/// has made a picture of it.
///
/// In this order:
///
/// 1. The black level is taken off, red and blue get their gains, what is brighter than white is white.
/// 2. Luma: (R + 2 G + B) / 4 at every pixel, by the kernel 1 2 1 / 2 4 2 / 1 2 1. It weighs R : G : B as 1 : 2 : 1
///    wherever it stands, so edges do not move and a plain surface shows no pattern; and where the gains make paper
///    neutral, ink and paper look as to a sensor without a mosaic. The picture's borders are mirrored (reflect-101,
///    which keeps the phase).
/// 3. Colour: of each cell of 2 x 2 pixels its own red, blue and the mean of its greens. Nothing is interpolated.
/// 4. Tone: 255 times the square root of the light, luma and colours alike. A sensor's numbers are proportional to
///    light, their noise to its root, so that eight bits keep what ten or twelve say in the dark; and the code's reader
///    (firmware/colour) expects what cameras give, which is near a root. Colours become Cb and Cr by ITU-R BT.601, in
///    its full range.
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "image/chroma_view.h"

namespace ninedot {

/// How a mosaic lies in memory.
struct BayerLayout {
  enum class Packing : std::uint8_t {
    kBytes,   ///< 8 bits
    kWords,   ///< 10 or 12 bits in the lower end of 16, little-endian
    kPacked,  ///< MIPI CSI-2: the upper eight bits of four (10) or two (12) samples, then a byte of their lower bits
  };
  Packing packing = Packing::kBytes;
  unsigned bits = 8;         ///< 8, 10 or 12
  int red_x = 0, red_y = 0;  ///< of the cell's red pixel, 0 or 1
};

/// What makes grey of a grey surface, and black of no light.
struct BayerBalance {
  double black_level = 0;              ///< in steps of the format, below its largest
  double red_gain = 1, blue_gain = 1;  ///< beside green, > 0
};

/// Threads: one at a time. Memory: three rows and the tables (32 kB), taken at construction.
class BayerDeveloper {
 public:
  /// \param width_px, height_px  at least 2 (contract)
  BayerDeveloper(const BayerLayout& layout, const BayerBalance& balance, int width_px, int height_px);

  /// Of the luma with the colours behind it, which `develop` writes.
  std::size_t picture_bytes() const noexcept { return luma_bytes() + 2 * cells_across() * cells_down(); }
  /// \param mosaic  height_px rows, `stride_bytes` apart, samples as the layout has them [LSB]
  /// \param picture  picture_bytes of it, not overlapping: luma row by row, then Cb and Cr in turn [LSB]
  void develop(const std::uint8_t* mosaic, std::size_t stride_bytes, std::uint8_t* picture) noexcept;
  /// The colours of what was developed. \param picture  as `develop` wrote it [LSB] Lifetime: as the picture's.
  ChromaView chroma_of(const std::uint8_t* picture) const noexcept;

 private:
  static constexpr unsigned kLightBits = 13;
  static constexpr std::uint16_t kWhite = (1U << kLightBits) - 1;
  using LightTable = std::array<std::uint16_t, 4096>;  // of a sample, by its number

  std::size_t luma_bytes() const noexcept { return width_ * height_; }
  std::size_t cells_across() const noexcept { return (width_ + 1) / 2; }
  std::size_t cells_down() const noexcept { return (height_ + 1) / 2; }

  void read_row(const std::uint8_t* mosaic, std::size_t stride_bytes, std::ptrdiff_t y, std::uint16_t* light) noexcept;
  void write_luma(const std::uint16_t* above, const std::uint16_t* here, const std::uint16_t* below,
                  std::uint8_t* luma) const noexcept;
  void write_chroma(const std::uint16_t* even, const std::uint16_t* odd, std::uint8_t* chroma) const noexcept;

  const BayerLayout layout_;
  const std::size_t width_, height_;
  std::array<LightTable, 3> light_;  // red, green, blue
  std::array<std::uint8_t, kWhite + 1> tone_;
  std::array<std::vector<std::uint16_t>, 3> rows_;  // with a mirrored pixel before and after
};

/// Least bytes of one row; packed samples come in whole groups.
std::size_t bayer_row_bytes(const BayerLayout& layout, std::size_t width_px) noexcept;

}  // namespace ninedot
