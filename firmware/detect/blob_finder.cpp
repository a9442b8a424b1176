#include "detect/blob_finder.h"

#include <algorithm>
#include <cmath>

#include "base/contract.h"
#include "detect/blob_moments.h"
#include "image/noise.h"
#include "image/pyramid.h"

// Every level of the pyramid finds spots of 2 to about 20 of its own pixels with one small square; a dot of 130 px is a
// dot of 16 px three levels up, where the noise is an eighth. Dark regions that fill the ellipse of their own moments
// become blobs.

namespace ninedot {
namespace {

constexpr int kMinArea_px2 = 2;  // a dot of 2.6 px diameter, blurred, may leave no more at the half level
// Of a region at its level. The threshold's square is 24 px there, so that a spot is narrower than that; it is as long
// as this where it is a circle seen from 66 degrees aside. What is longer is seen whole a level up.
constexpr int kMaxSide_px = 60;
constexpr int kMinContrast_lsb = 10;  // a dot that differs less from its paper is not measurable
// Sigmas of the level's own noise; the threshold is of the half-size picture, whose noise is half of that. Pure noise
// of 6 grey levels then leaves fewer than 300 blobs (BlobFinder.TakesBlankPaperAndPureNoiseForNothing).
constexpr double kContrastPerNoise = 4.0;

}  // namespace

float Blob::semi_major_px() const noexcept {
  const float mean = 0.5F * (xx_px2 + yy_px2);
  const float half_difference = 0.5F * (xx_px2 - yy_px2);
  const float spread = std::sqrt(half_difference * half_difference + xy_px2 * xy_px2);
  return 2 * std::sqrt(std::max(mean + spread, 0.0F));
}

bool Blob::is_finite() const noexcept {
  return std::isfinite(x_px + y_px) && std::isfinite(area_px2 + xx_px2 + xy_px2 + yy_px2);
}

BlobFinder::BlobFinder(int width_px, int height_px)
    : levels_{ImageBuffer(std::max(width_px / 2, 1), std::max(height_px / 2, 1)),
              ImageBuffer(std::max(width_px / 4, 1), std::max(height_px / 4, 1)),
              ImageBuffer(std::max(width_px / 8, 1), std::max(height_px / 8, 1)),
              ImageBuffer(std::max(width_px / 16, 1), std::max(height_px / 16, 1))},
      threshold_(std::max(width_px / 2, 1), std::max(height_px / 2, 1)),
      regions_(width_px, height_px),
      coarser_(width_px, height_px) {}

void BlobFinder::find_blobs(const ImageView& luma, Levels wanted, BlobList& blobs) noexcept {
  EXPECTS(wanted.first >= 0 && wanted.first <= wanted.last && wanted.last < kLevels);
  blobs.clear();
  noise_lsb_ = estimate_noise_lsb(luma);
  for (int i = 0; i <= wanted.last; ++i) halve(i == 0 ? luma : levels_[i - 1].view(), levels_[i]);
  searched_ = wanted;
  for (int level = wanted.last; level >= wanted.first; --level) search_level(luma, level, blobs);
}

void BlobFinder::add_finer_level(const ImageView& luma, BlobList& blobs) noexcept {
  EXPECTS(searched_.first > 0);
  search_level(luma, --searched_.first, blobs);
}

void BlobFinder::search_level(const ImageView& luma, int level, BlobList& blobs) noexcept {
  const ImageView picture = level == 0 ? luma : levels_[level - 1].view();
  if (levels_[level].width_px() < 2 || levels_[level].height_px() < 2) return;
  const double level_noise_lsb = noise_lsb_ / (1 << level);
  const int min_contrast = std::max(kMinContrast_lsb, static_cast<int>(kContrastPerNoise * level_noise_lsb));
  const ImageBuffer& threshold = threshold_.compute(levels_[level].view(), min_contrast);
  collect(picture, regions_.find(picture, threshold, {kMinArea_px2, kMaxSide_px}), level, blobs);
}

void BlobFinder::collect(const ImageView& picture, std::span<const Region> regions, int level,
                         BlobList& blobs) noexcept {
  // Squared distance of two centroids, in areas of the coarser blob: 0.3 of a disc's radius. Two dots cannot be so
  // close.
  constexpr float kSamePlace = 0.03F;
  // Ratio of two areas: below the 4 between P9 and a dot of the ring.
  constexpr float kSameSize = 2.5F;
  const auto scale = static_cast<double>(1 << level);
  const double noise_lsb = noise_lsb_ / scale;
  coarser_.build(blobs.span());
  bool any_replaced = false;
  for (const Region& region : regions) {
    Moments m;
    if (!measure_blob(picture, region, noise_lsb, m)) continue;
    const Blob blob{static_cast<float>((m.x_px + 0.5) * scale - 0.5),
                    static_cast<float>((m.y_px + 0.5) * scale - 0.5),
                    static_cast<float>(m.area_px2 * scale * scale),
                    static_cast<float>(m.xx_px2 * scale * scale),
                    static_cast<float>(m.xy_px2 * scale * scale),
                    static_cast<float>(m.yy_px2 * scale * scale),
                    level};
    if (!blob.is_finite()) continue;
    // The same dot, seen one or more levels up: the finest one replaces them all.
    Blob* place = nullptr;
    const float reach_px = std::sqrt(kSamePlace * kSameSize * blob.area_px2);
    coarser_.for_each_near(blob.x_px, blob.y_px, reach_px, [&](std::size_t i) {
      Blob& other = blobs[i];
      const float dx = other.x_px - blob.x_px, dy = other.y_px - blob.y_px;
      const bool same = other.level > level && dx * dx + dy * dy < kSamePlace * other.area_px2 &&
                        blob.area_px2 * kSameSize > other.area_px2 && blob.area_px2 < kSameSize * other.area_px2;
      if (!same) return;
      if (place == nullptr) {
        place = &other;
      } else {
        other.area_px2 = 0;
        any_replaced = true;
      }
    });
    if (place != nullptr) {
      *place = blob;
    } else if (!blobs.try_push_back(blob)) {
      ++blobs_cut_;
    }
  }
  if (!any_replaced) return;
  const Blob* end = std::remove_if(blobs.begin(), blobs.end(), [](const Blob& b) { return b.area_px2 == 0; });
  while (blobs.end() != end) blobs.pop_back();
}

}  // namespace ninedot
