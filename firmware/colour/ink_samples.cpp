#include "colour/ink_samples.h"

#include <algorithm>
#include <cmath>

#include "base/contract.h"
#include "colour/blocks.h"

namespace ninedot {
namespace {

constexpr float kLargeDisc_px = 5;   // semi-minor axis from which enough blocks lie whole inside
constexpr float kWholeCover = 0.9F;  // a block of a large disc is ink from this on, and paper below one minus this

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
  const Eigen::Vector2f centre = blocks.block_at(disc.centre_px);
  InkSums sums;
  const BlockRange range = blocks.around(centre, {half_width, half_height});
  if (range.empty()) return sums;
  const float surplus = std::max(1.0F, 4 * half_width * half_height / most_blocks);
  const float step_down = std::ceil(std::sqrt(surplus)), step_across = std::ceil(surplus / step_down);
  const int step_y = static_cast<int>(step_down), step_x = static_cast<int>(step_across);

  const Eigen::Matrix2f radius_per_block = disc.radius_per_px * Eigen::Vector2f(width_px, height_px).asDiagonal();
  const float reach2 = paper.reach_radii * paper.reach_radii;
  const float sheet_radii = paper.sheet_radii - kPaperMargin_px / disc.semi_minor_px;
  const float sheet2 = sheet_radii > 0 ? sheet_radii * sheet_radii : 0;
  const bool is_large = disc.semi_minor_px > kLargeDisc_px;
  for (int y = range.y_begin; y < range.y_end; y += step_y)
    for (int x = range.x_begin; x < range.x_end; x += step_x) {
      const Eigen::Vector2f on_sheet =
          radius_per_block * (Eigen::Vector2f(static_cast<float>(x), static_cast<float>(y)) - centre);
      if (on_sheet.squaredNorm() > reach2 || (on_sheet + paper.disc_radii).squaredNorm() > sheet2) continue;
      const float cover = disc.cover(disc.inside_px(on_sheet), kBlockBlur_px);
      if (is_large && cover > 1 - kWholeCover && cover < kWholeCover) continue;
      add(cover, blocks.light_at(x, y), sums);
    }
  sums.light2 = sums.light2.selfadjointView<Eigen::Lower>();
  return sums;
}

}  // namespace ninedot
