#include "detect/blob_finder.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/contract.h"

// Every level of the pyramid finds spots of 2 to about 20 of its own pixels with one small square; a dot of 130 px is a
// dot of 16 px three levels up, where the noise is an eighth. Dark regions that fill the ellipse of their own moments
// become blobs.

namespace ninedot {
namespace {

constexpr int kMinArea_px2 = 2;             // a dot of 2.6 px diameter, blurred, may leave no more at the half level
constexpr int kMaxSide_px = 60;             // of a region at its level; larger ones are better seen a level up
constexpr int kGreyMomentsBelow_px2 = 120;  // moments of grey levels are worth their time for small blobs only
constexpr int kMinContrast_lsb = 10;        // a dot that differs less from its paper is not measurable
constexpr double kContrastPerNoise = 4.0;   // of the half-size picture's threshold: 4 sigma of the level's noise

/// Rejects what does not fill its own moments' ellipse: area / (4 pi sqrt(det M)) is 1 for every ellipse, 0.95 for a
/// square, and falls for rings, crosses and crescents. Small blobs are ragged; large ones measured 0.97 .. 1.03.
bool fills_its_ellipse(double area, double xx, double xy, double yy) noexcept {
  const double determinant = xx * yy - xy * xy;
  if (!(determinant > 0)) return false;
  const double fill = area / (4 * std::numbers::pi * std::sqrt(determinant));
  const double slack = area < 30 ? 0.35 : 0.12;
  return fill > 1 - slack && fill < 1 + slack;
}

}  // namespace

float Blob::semi_major_px() const noexcept {
  const float mean = 0.5F * (xx_px2 + yy_px2);
  const float half_difference = 0.5F * (xx_px2 - yy_px2);
  return 2 * std::sqrt(mean + std::sqrt(half_difference * half_difference + xy_px2 * xy_px2));
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

namespace {

struct Moments {
  double area, x, y, xx, xy, yy;
};

/// Moments weighted by darkness, over the box and two pixels around it. The paper's level is the mean of the box's rim.
bool grey_moments(const ImageView& picture, const Region& region, double noise_lsb, Moments& m) noexcept {
  const int x0 = std::max(region.min_x - 2, 0), x1 = std::min(region.end_x + 2, picture.width_px);
  const int y0 = std::max(region.min_y - 2, 0), y1 = std::min(region.last_y + 3, picture.height_px);
  double rim = 0;
  int rim_count = 0;
  for (int x = x0; x < x1; ++x) rim += picture.at(x, y0) + picture.at(x, y1 - 1), rim_count += 2;
  for (int y = y0 + 1; y < y1 - 1; ++y) rim += picture.at(x0, y) + picture.at(x1 - 1, y), rim_count += 2;
  const double paper = rim / rim_count;
  int darkest = 255;
  for (int y = y0; y < y1; ++y)
    for (int x = x0; x < x1; ++x) darkest = std::min<int>(darkest, picture.at(x, y));
  const double contrast = paper - darkest;
  if (contrast <= 0) return false;
  const double rise = 4 * noise_lsb;
  const double floor = std::max(0.12 * contrast, 2 * noise_lsb);
  // Without branches but for the rim: most of what is measured here is noise, and no processor foresees noise.
  double s = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
  for (int y = y0; y < y1; ++y) {
    const std::uint8_t* row = picture.row(y);
    // What gets darker again further out is something else: another dot, the wall beyond the sheet.
    const std::uint8_t* nearer = picture.row(std::clamp(y, y0 + 1, y1 - 2));
    const auto weight_at = [&](int x, int nearer_x) {
      const double weight = paper - row[x];
      const bool counts = (weight >= floor) & (row[x] + rise >= nearer[nearer_x]);
      return counts ? weight : 0.0;
    };
    double row_s = 0, row_x = 0, row_xx = 0;
    const auto add = [&](int x, double weight) { row_s += weight, row_x += weight * x, row_xx += weight * x * x; };
    add(x0, weight_at(x0, x0 + 1));
    for (int x = x0 + 1; x < x1 - 1; ++x) add(x, weight_at(x, x));
    add(x1 - 1, weight_at(x1 - 1, x1 - 2));
    s += row_s, sx += row_x, sxx += row_xx;
    sy += row_s * y, sxy += row_x * y, syy += row_s * y * y;
  }
  if (s <= 0) return false;
  m.x = sx / s, m.y = sy / s;
  m.xx = sxx / s - m.x * m.x, m.xy = sxy / s - m.x * m.y, m.yy = syy / s - m.y * m.y;
  m.area = s / contrast;
  return true;
}

/// Moments of what may be a dot, in the pixels of its level. \return false: it is none
bool moments_of(const ImageView& picture, const Region& region, double noise_lsb, Moments& m) noexcept {
  const double area = region.area_px;
  m = {area, static_cast<double>(region.sum_x) / area, static_cast<double>(region.sum_y) / area, 0, 0, 0};
  // 1/12: each pixel is a square, not a point.
  m.xx = static_cast<double>(region.sum_xx) / area - m.x * m.x + 1.0 / 12;
  m.yy = static_cast<double>(region.sum_yy) / area - m.y * m.y + 1.0 / 12;
  m.xy = static_cast<double>(region.sum_xy) / area - m.x * m.y;
  if (!fills_its_ellipse(m.area, m.xx, m.xy, m.yy)) return false;
  if (area >= kGreyMomentsBelow_px2) return true;
  Moments grey;
  if (!grey_moments(picture, region, noise_lsb, grey)) return false;
  // A neighbour that reaches into the box spoils grey moments; then the outline's own are the better ones.
  const bool agrees = std::hypot(grey.x - m.x, grey.y - m.y) < 0.25 * std::sqrt(area) && grey.xx < 2.0 * m.xx + 1 &&
                      grey.yy < 2.0 * m.yy + 1;
  if (agrees) grey.area = m.area, m = grey;
  return true;
}

}  // namespace

void BlobFinder::collect(const ImageView& picture, std::span<const Region> regions, int level,
                         BlobList& blobs) noexcept {
  constexpr float kSamePlace = 0.03F;  // squared distance of two centroids, in areas of the coarser blob
  constexpr float kSameSize = 2.5F;    // ratio of two areas
  const auto scale = static_cast<double>(1 << level);
  const double noise_lsb = noise_lsb_ / scale;
  coarser_.build(blobs.span());
  bool any_replaced = false;
  for (const Region& region : regions) {
    Moments m;
    if (!moments_of(picture, region, noise_lsb, m)) continue;
    const Blob blob{static_cast<float>((m.x + 0.5) * scale - 0.5),
                    static_cast<float>((m.y + 0.5) * scale - 0.5),
                    static_cast<float>(m.area * scale * scale),
                    static_cast<float>(m.xx * scale * scale),
                    static_cast<float>(m.xy * scale * scale),
                    static_cast<float>(m.yy * scale * scale),
                    level};
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
      break;
    }
  }
  if (!any_replaced) return;
  const Blob* end = std::remove_if(blobs.begin(), blobs.end(), [](const Blob& b) { return b.area_px2 == 0; });
  while (blobs.end() != end) blobs.pop_back();
}

}  // namespace ninedot
