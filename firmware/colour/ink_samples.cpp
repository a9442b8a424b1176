#include "colour/ink_samples.h"

#include <algorithm>
#include <cmath>

#include "base/contract.h"

namespace ninedot {
namespace {

// What a block of 2 x 2 pixels sees, 1-sigma per axis: the block's square (4/12 px^2), the lens (0.5 px) and the
// interpolation of a Bayer pattern (a triangle of two pixels each way, 4/6 px^2).
constexpr float kBlur_px = 1.1F;
constexpr float kMargin_px = 1.0F;   // of the paper's edge: a blur's width
constexpr float kLargeDisc_px = 5;   // semi-minor axis from which enough blocks lie whole inside
constexpr float kWholeCover = 0.9F;  // a block of a large disc is ink from this on, and paper below one minus this

/// The picture cut into blocks of whole chroma samples, at least two pixels each way. Blocks at its right and lower end
/// that it cuts are left out.
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
  int width_px() const noexcept { return width_px_; }
  int height_px() const noexcept { return height_px_; }
  int across() const noexcept { return luma_.width_px / width_px_; }
  int down() const noexcept { return luma_.height_px / height_px_; }

  /// Red, green and blue of a block by BT.601 (chroma_view.h), each squared: the tone curves of cameras are near enough
  /// to a square root.
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
  const ImageView& luma_;
  const ChromaView& chroma_;
  int columns_, rows_;  // chroma samples of a block
  int width_px_, height_px_;
  float luma_scale_, chroma_scale_;  // from sums over a block to 1 for 255
};

/// Only what is different of a symmetric product.
void add(float cover, const Eigen::Vector3f& light, InkSums& sums) noexcept {
  sums.count += 1, sums.cover += cover, sums.cover2 += cover * cover;
  sums.light += light, sums.covered_light += cover * light;
  sums.light2.diagonal() += light.cwiseAbs2();
  sums.light2(1, 0) += light.x() * light.y();
  sums.light2(2, 0) += light.x() * light.z();
  sums.light2(2, 1) += light.y() * light.z();
}

}  // namespace

InkSums sum_samples(const ImageView& luma, const ChromaView& chroma, const DiscPicture& disc, const PaperAround& paper,
                    float most_blocks) noexcept {
  EXPECTS(!chroma.empty() && chroma.width > 0 && chroma.height > 0);
  const Blocks blocks(luma, chroma);
  const auto width_px = static_cast<float>(blocks.width_px()), height_px = static_cast<float>(blocks.height_px());
  const float half_width = paper.reach_radii * disc.px_per_radius.row(0).norm() / width_px;  // [blocks]
  const float half_height = paper.reach_radii * disc.px_per_radius.row(1).norm() / height_px;
  const Eigen::Vector2f centre((disc.centre_px.x() + 0.5F) / width_px - 0.5F,
                               (disc.centre_px.y() + 0.5F) / height_px - 0.5F);
  InkSums sums;
  // Comparisons that hold for numbers only, before anything is turned into whole ones.
  if (!(centre.x() + half_width > 0 && centre.x() - half_width < static_cast<float>(blocks.across()) &&
        centre.y() + half_height > 0 && centre.y() - half_height < static_cast<float>(blocks.down())))
    return sums;
  const int x_begin = static_cast<int>(std::max(0.0F, std::ceil(centre.x() - half_width)));
  const int y_begin = static_cast<int>(std::max(0.0F, std::ceil(centre.y() - half_height)));
  const int x_end = static_cast<int>(std::min(static_cast<float>(blocks.across()), centre.x() + half_width + 1));
  const int y_end = static_cast<int>(std::min(static_cast<float>(blocks.down()), centre.y() + half_height + 1));
  const float surplus = std::max(1.0F, 4 * half_width * half_height / most_blocks);
  const float step_down = std::ceil(std::sqrt(surplus)), step_across = std::ceil(surplus / step_down);
  const int step_y = static_cast<int>(step_down), step_x = static_cast<int>(step_across);

  const Eigen::Matrix2f radius_per_block = disc.radius_per_px * Eigen::Vector2f(width_px, height_px).asDiagonal();
  const float reach2 = paper.reach_radii * paper.reach_radii;
  const float sheet_radii = paper.sheet_radii - kMargin_px / disc.semi_minor_px;
  const float sheet2 = sheet_radii > 0 ? sheet_radii * sheet_radii : 0;
  const bool is_large = disc.semi_minor_px > kLargeDisc_px;
  for (int y = y_begin; y < y_end; y += step_y)
    for (int x = x_begin; x < x_end; x += step_x) {
      const Eigen::Vector2f on_sheet =
          radius_per_block * (Eigen::Vector2f(static_cast<float>(x), static_cast<float>(y)) - centre);
      if (on_sheet.squaredNorm() > reach2 || (on_sheet + paper.disc_radii).squaredNorm() > sheet2) continue;
      const float cover = disc.cover(disc.inside_px(on_sheet), kBlur_px);
      if (is_large && cover > 1 - kWholeCover && cover < kWholeCover) continue;
      add(cover, blocks.light_at(x, y), sums);
    }
  sums.light2 = sums.light2.selfadjointView<Eigen::Lower>();
  return sums;
}

}  // namespace ninedot
