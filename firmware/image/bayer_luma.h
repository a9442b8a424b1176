#pragma once
/// Grey levels in which a colour camera's pattern hides least.
///
/// A sensor behind a Bayer pattern sees red and blue on one pixel of four each, and whoever interpolates them takes
/// what is finer than two pixels for something coarser: edges move by a tenth of a pixel, in red one way where in blue
/// they move the other way (they stand on odd and even columns, and rows). In (R + 2 G + B) / 4 both cancel (Alleysson,
/// Suesstrunk & Herault, "Linear demosaicing inspired by the human visual system", IEEE Trans. Image Processing 14,
/// 2005); luma has 2.6 times as much red as blue, and keeps most of red's.
#include <array>
#include <cstdint>
#include <vector>

#include "image/chroma_view.h"
#include "image/image_view.h"

namespace ninedot {

/// Memory: everything is allocated by the constructor. Threads: one caller.
class BayerLuma {
 public:
  /// \param width_px, height_px  of the largest picture
  BayerLuma(int width_px, int height_px);

  /// \param luma  no larger than the constructor was told, else it is handed back as it is; likewise without a
  /// chroma, and where its luma is balanced already
  /// \return  as large as `luma`; until the next call
  ImageView of(const ImageView& luma, const ChromaView& chroma) noexcept;

 private:
  const std::int16_t* weighed_row(const ChromaView& chroma, int row) noexcept;
  void mix_rows(const ChromaView& chroma, int block, int y) noexcept;
  void spread_row(int columns, int width_px) noexcept;

  int width_px_, height_px_;
  std::vector<std::uint8_t> pixels_;
  std::array<std::vector<std::int16_t>, 3> weighed_;  ///< of a row of chroma: what is to be added to luma [LSB/64]
  std::array<int, 3> weighed_row_{};                  ///< which row that is
  std::vector<std::int16_t> mixed_;                   ///< the same at a row of pixels
  std::vector<std::int16_t> spread_;                  ///< and at every pixel of it
};

}  // namespace ninedot
