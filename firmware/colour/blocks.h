#pragma once
/// A picture in blocks of pixels that are as coarse as its chroma.
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "image/chroma_view.h"
#include "image/image_view.h"

namespace ninedot {

/// What a block of 2 x 2 pixels sees, 1-sigma per axis [px]: the block's square (4/12 px^2), the lens (0.5 px) and the
/// interpolation of a Bayer pattern (a triangle of two pixels each way, 4/6 px^2).
inline constexpr float kBlockBlur_px = 1.1F;
/// Of the paper's edge, from which on no block is taken: a blur's width [px].
inline constexpr float kPaperMargin_px = 1.0F;

/// Some blocks of a picture, those at the ends left out.
struct BlockRange {
  int x_begin = 0, x_end = 0, y_begin = 0, y_end = 0;  ///< [blocks]
  bool empty() const noexcept { return x_begin >= x_end || y_begin >= y_end; }
};

/// The picture cut into blocks of whole chroma samples, at least two pixels each way. Blocks at its right and lower end
/// that it cuts are left out. Memory: none; the pixels must outlive it. Threads: const is safe.
class Blocks {
 public:
  Blocks(const ImageView& luma, const ChromaView& chroma) noexcept : luma_(luma), chroma_(chroma) {
    const int sample_width_px = (luma.width_px + chroma.width - 1) / chroma.width;
    const int sample_height_px = (luma.height_px + chroma.height - 1) / chroma.height;
    columns_ = sample_width_px >= 2 ? 1 : 2;
    rows_ = sample_height_px >= 2 ? 1 : 2;
    width_px_ = columns_ * sample_width_px, height_px_ = rows_ * sample_height_px;
    luma_scale_ = 1.0F / (255.0F * static_cast<float>(width_px_ * height_px_));
    chroma_scale_ = 1.0F / (255.0F * static_cast<float>(columns_ * rows_));
  }
  /// Of a block [px].
  int width_px() const noexcept { return width_px_; }
  int height_px() const noexcept { return height_px_; }

  /// Where a place of the picture lies [blocks], pixel centres and block centres at integers.
  Eigen::Vector2f block_at(const Eigen::Vector2f& px) const noexcept {
    return {(px.x() + 0.5F) / static_cast<float>(width_px_) - 0.5F,
            (px.y() + 0.5F) / static_cast<float>(height_px_) - 0.5F};
  }

  /// Those of the picture that are no farther from a place than this in x and in y. \param middle, half  [blocks]
  BlockRange around(const Eigen::Vector2f& middle, const Eigen::Vector2f& half) const noexcept {
    const int columns = luma_.width_px / width_px_, rows = luma_.height_px / height_px_;  // whole ones
    const auto across = static_cast<float>(columns), down = static_cast<float>(rows);
    // Comparisons that hold for numbers only, before anything is turned into whole ones.
    if (!(middle.x() + half.x() > 0 && middle.x() - half.x() < across && middle.y() + half.y() > 0 &&
          middle.y() - half.y() < down))
      return {};
    return {static_cast<int>(std::max(0.0F, std::ceil(middle.x() - half.x()))),
            static_cast<int>(std::min(across, middle.x() + half.x() + 1)),
            static_cast<int>(std::max(0.0F, std::ceil(middle.y() - half.y()))),
            static_cast<int>(std::min(down, middle.y() + half.y() + 1))};
  }

  /// Red, green and blue of a block by BT.601 (chroma_view.h), each squared: the tone curves of cameras are near enough
  /// to a square root. [1]
  Eigen::Vector3f light_at(int block_x, int block_y) const noexcept {
    int grey_sum = 0, cb_sum = 0, cr_sum = 0;
    const std::uint8_t* row = luma_.row(block_y * height_px_) + std::ptrdiff_t{block_x} * width_px_;
    for (int j = 0; j < height_px_; ++j, row += luma_.stride_bytes)
      for (int i = 0; i < width_px_; i += 2) grey_sum += row[i] + row[i + 1];
    const std::ptrdiff_t at = std::ptrdiff_t{block_y} * rows_ * chroma_.stride_bytes +
                              std::ptrdiff_t{block_x} * columns_ * chroma_.step_bytes;
    for (int j = 0; j < rows_; ++j)
      for (int i = 0; i < columns_; ++i) {
        const std::ptrdiff_t sample = at + j * chroma_.stride_bytes + i * chroma_.step_bytes;
        cb_sum += chroma_.cb[sample], cr_sum += chroma_.cr[sample];
      }
    const int no_colour = 128 * columns_ * rows_;
    const float grey = static_cast<float>(grey_sum) * luma_scale_;
    const float cb = static_cast<float>(cb_sum - no_colour) * chroma_scale_;
    const float cr = static_cast<float>(cr_sum - no_colour) * chroma_scale_;
    const Eigen::Vector3f coded(grey + 1.402F * cr, grey - 0.344F * cb - 0.714F * cr, grey + 1.772F * cb);
    return coded.cwiseMax(0.0F).cwiseAbs2();
  }

 private:
  ImageView luma_;
  ChromaView chroma_;
  int columns_, rows_;  // chroma samples of a block
  int width_px_, height_px_;
  float luma_scale_, chroma_scale_;  // from sums over a block to 1 for 255
};

}  // namespace ninedot
