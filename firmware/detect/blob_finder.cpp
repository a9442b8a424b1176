#include "detect/blob_finder.h"

#include <algorithm>
#include <cmath>

#include "base/contract.h"
#include "detect/blob_moments.h"
#include "image/noise.h"
#include "image/pyramid.h"
#include "image/smooth.h"

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
// Sigmas of the noise of the half-size picture, which the threshold comes from. Pure noise of 6 grey levels then leaves
// fewer than 300 blobs (Noises.AreTakenForNothing).
constexpr double kContrastPerNoise = 8.0;
// From here on [grey levels, 1-sigma] level 0 is smoothed: below, the contrast that noise asks for is at most half of
// what ink has in poor light, and what smoothing adds to a dot's blur loses more than it gains. Dots of 2 to 5 px have
// no other level.
constexpr double kNoisy_lsb = 8;

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
      rows_(width_px, height_px),
      smoothed_(width_px, height_px),
      half_smoothed_(std::max(width_px / 2, 1), std::max(height_px / 2, 1)),
      threshold_(std::max(width_px / 2, 1), std::max(height_px / 2, 1)),
      regions_(width_px, height_px),
      coarser_(width_px, height_px),
      width_px_(width_px),
      height_px_(height_px) {}

void BlobFinder::find_blobs(const ImageView& luma, Levels wanted, BlobList& blobs, WorkBudget& budget) noexcept {
  EXPECTS(wanted.first >= 0 && wanted.first <= wanted.last && wanted.last < kLevels);
  blobs.clear();
  noise_lsb_ = estimate_noise_lsb(luma);
  is_smoothed_ = false;
  for (int i = 0; i <= wanted.last; ++i) halve(i == 0 ? luma : levels_[i - 1].view(), levels_[i]);
  searched_ = wanted;
  for (int level = wanted.last; level >= wanted.first; --level) search_level(luma, level, blobs, budget);
}

void BlobFinder::add_finer_level(const ImageView& luma, BlobList& blobs, WorkBudget& budget) noexcept {
  EXPECTS(searched_.first > 0);
  search_level(luma, --searched_.first, blobs, budget);
}

ImageView BlobFinder::picture_at(int level) const noexcept {
  EXPECTS(level > 0 || is_smoothed_);
  return level > 0 ? levels_[level - 1].view() : smoothed_.view();
}

double BlobFinder::noise_at_lsb(int level) const noexcept {
  return level == 0 && is_smoothed_ ? kSmoothedNoise * noise_lsb_ : noise_lsb_ / (1 << level);
}

BlobFinder::Searched BlobFinder::level_of(const ImageView& luma, int level) noexcept {
  if (level > 0) return {picture_at(level), levels_[level].view(), noise_at_lsb(level), noise_at_lsb(level + 1)};
  if (noise_lsb_ < kNoisy_lsb) return {luma, levels_[0].view(), noise_lsb_, noise_at_lsb(1)};
  is_smoothed_ = true;
  smooth(luma, rows_, smoothed_);
  halve(smoothed_.view(), half_smoothed_);
  return {smoothed_.view(), half_smoothed_.view(), noise_at_lsb(0), kHalfSmoothedNoise * noise_lsb_};
}

void BlobFinder::search_level(const ImageView& luma, int level, BlobList& blobs, WorkBudget& budget) noexcept {
  constexpr int kOverlap = 8;  // of the picture's height: rows searched again, so that no dot lies on a seam
  if (levels_[level].width_px() < 2 || levels_[level].height_px() < 2) return;
  const Searched searched = level_of(luma, level);
  const int min_contrast = std::max(kMinContrast_lsb, static_cast<int>(kContrastPerNoise * searched.half_noise_lsb));
  const ImageBuffer& threshold = threshold_.compute(searched.half, min_contrast);
  const bool is_whole = luma.width_px == width_px_ && luma.height_px == height_px_;
  Begin once;
  Begin& begin = is_whole ? begin_[static_cast<std::size_t>(level)] : once;
  const auto regions = regions_.find(searched.picture, threshold, {kMinArea_px2, kMaxSide_px}, begin.row);
  const bool is_cut = regions_.cut_from_row() < searched.picture.height_px;
  if (is_cut || begin.row > 0) budget.is_overdrawn = true;
  begin.row = is_cut ? std::max(regions_.cut_from_row() - searched.picture.height_px / kOverlap, 0) : 0;
  const auto collect_all = [&](int& allowance) {
    return collect(searched, regions, level, allowance, begin.region, blobs);
  };
  const bool got_through = level == 0 ? collect_all(budget.regions) : with_half(budget.regions, collect_all);
  budget.is_overdrawn |= !got_through;
}

/// \return  whether all had room; else begin_at is the first that had none
bool BlobFinder::collect(const Searched& searched, std::span<const Region> regions, int level, int& allowance,
                         std::size_t& begin_at, BlobList& blobs) noexcept {
  const auto scale = static_cast<double>(1 << level);
  coarser_.build(blobs.span());
  const std::size_t done = go_round(regions.size(), begin_at, [&](std::size_t i) {
    if (!take_one(allowance)) return false;
    Moments m;
    if (!measure_blob(searched.picture, regions[i], searched.noise_lsb, m)) return true;
    const Blob blob{static_cast<float>((m.x_px + 0.5) * scale - 0.5),
                    static_cast<float>((m.y_px + 0.5) * scale - 0.5),
                    static_cast<float>(m.area_px2 * scale * scale),
                    static_cast<float>(m.xx_px2 * scale * scale),
                    static_cast<float>(m.xy_px2 * scale * scale),
                    static_cast<float>(m.yy_px2 * scale * scale),
                    level};
    return !blob.is_finite() || add_blob(blob, blobs);
  });
  blobs_cut_ += static_cast<std::uint32_t>(regions.size() - done);
  const Blob* end = std::remove_if(blobs.begin(), blobs.end(), [](const Blob& b) { return b.area_px2 == 0; });
  blobs.truncate(static_cast<std::size_t>(end - blobs.begin()));
  return done == regions.size();
}

/// The same dot, seen one or more levels up: the finest one replaces them all; what they leave has no area.
bool BlobFinder::add_blob(const Blob& blob, BlobList& blobs) noexcept {
  // Squared distance of two centroids, in areas of the coarser blob: 0.3 of a disc's radius. Two dots cannot be so
  // close.
  constexpr float kSamePlace = 0.03F;
  // Ratio of two areas: below the 4 between P9 and a dot of the ring.
  constexpr float kSameSize = 2.5F;
  Blob* place = nullptr;
  const float reach_px = std::sqrt(kSamePlace * kSameSize * blob.area_px2);
  coarser_.for_each_near(blob.x_px, blob.y_px, reach_px, [&](std::size_t i) {
    Blob& other = blobs[i];
    const float dx = other.x_px - blob.x_px, dy = other.y_px - blob.y_px;
    const bool same = other.level > blob.level && dx * dx + dy * dy < kSamePlace * other.area_px2 &&
                      blob.area_px2 * kSameSize > other.area_px2 && blob.area_px2 < kSameSize * other.area_px2;
    if (!same) return;
    if (place == nullptr)
      place = &other;
    else
      other.area_px2 = 0;
  });
  if (place == nullptr) return blobs.try_push_back(blob);
  *place = blob;
  return true;
}

}  // namespace ninedot
