#include "detect/blob_moments.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/contract.h"

// Variances are E[x^2] - E[x]^2 with x counted from the middle of the box, an integer. Counted from the picture's
// corner both terms are up to 10^6 times as large as their difference, and for a single pixel rounding decides its
// sign.

namespace ninedot {
namespace {

// Moments of grey levels are worth their time for small blobs only: at 12 px diameter an outline of whole pixels, 38 of
// them with an error of 0.3 px each, has its centroid right to 0.07 px, and what reads blobs needs no better.
constexpr int kGreyMomentsBelow_px2 = 120;
constexpr int kAround_px = 2;  // around the box of a region: where half the darkness is not reached but some is
// Of a pixel's darkness to count. Below two sigma it is noise; an eighth of the contrast is what blur of 0.6 px leaves
// 0.7 px outside of an edge, and what is farther out belongs to paper, texture and neighbours.
constexpr double kFloorShare = 0.12, kFloorPerNoise = 2;
constexpr double kRisePerNoise = 4;  // darker than the pixel nearer to the blob by this is no noise
// A neighbour in the box pulls the centroid (here by more than 0.44 of a disc's radius) and doubles the variance; blur
// adds less than a square pixel.
constexpr double kPulled = 0.25, kWidened = 2.0, kWidened_px2 = 1;
// What fills the ellipse of its moments by less or more than this is none. Ellipses drawn at random places, 1 to 0.4 in
// their axes: from 30 pixels on 0.88 at least, from 120 on 0.967; of fewer pixels 99 % have 0.68 or more.
constexpr double kRaggedBelow_px2 = 30, kRaggedSlack = 0.35, kSlack = 0.12;

/// Rejects what does not fill its own moments' ellipse: area / (4 pi sqrt(det M)) is 1 for every ellipse, 0.95 for a
/// square, and falls for rings, crosses and crescents. Small blobs are ragged; large ones measured 0.97 .. 1.03.
bool fills_its_ellipse(const Moments& m) noexcept {
  const double determinant = m.xx_px2 * m.yy_px2 - m.xy_px2 * m.xy_px2;
  if (!(determinant > 0)) return false;
  const double fill = m.area_px2 / (4 * std::numbers::pi * std::sqrt(determinant));
  const double slack = m.area_px2 < kRaggedBelow_px2 ? kRaggedSlack : kSlack;
  return fill > 1 - slack && fill < 1 + slack;
}

/// Raises the variance across the narrow way to that of a pixel: M + (least - narrow) n n^T, where n n^T =
/// (wide I - M) / (wide - narrow).
void widen_to_a_pixel(Moments& m) noexcept {
  const double mean = 0.5 * (m.xx_px2 + m.yy_px2);
  const double half = 0.5 * (m.xx_px2 - m.yy_px2);
  const double spread = std::sqrt(half * half + m.xy_px2 * m.xy_px2);
  const double missing = kPixelVariance_px2 - (mean - spread);
  if (missing <= 0) return;
  if (mean + spread <= kPixelVariance_px2) {
    m.xx_px2 = m.yy_px2 = kPixelVariance_px2;
    m.xy_px2 = 0;
    return;
  }
  // spread > 0 here: the wide way is above a pixel's, the narrow way below.
  const double share = missing / (2 * spread);
  m.xx_px2 += share * (mean + spread - m.xx_px2);
  m.yy_px2 += share * (mean + spread - m.yy_px2);
  m.xy_px2 -= share * m.xy_px2;
}

}  // namespace

Moments outline_moments(const Region& region) noexcept {
  const std::int64_t n = region.area_px;
  const std::int64_t ox = (region.min_x + region.end_x) / 2, oy = (region.min_y + region.last_y) / 2;
  const double area = region.area_px;
  // Whole numbers: moving the origin rounds nothing.
  const double x = static_cast<double>(region.sum_x - n * ox) / area;
  const double y = static_cast<double>(region.sum_y - n * oy) / area;
  const double xx = static_cast<double>(region.sum_xx - 2 * ox * region.sum_x + n * ox * ox) / area;
  const double yy = static_cast<double>(region.sum_yy - 2 * oy * region.sum_y + n * oy * oy) / area;
  const double xy = static_cast<double>(region.sum_xy - ox * region.sum_y - oy * region.sum_x + n * ox * oy) / area;
  Moments m;
  m.area_px2 = area;
  m.x_px = static_cast<double>(ox) + x;
  m.y_px = static_cast<double>(oy) + y;
  m.xx_px2 = xx - x * x + kPixelVariance_px2;
  m.yy_px2 = yy - y * y + kPixelVariance_px2;
  m.xy_px2 = xy - x * y;
  return m;
}

bool measure_darkness(const ImageView& picture, const Region& region, double noise_lsb, Moments& m) noexcept {
  const int x0 = std::max(region.min_x - kAround_px, 0), x1 = std::min(region.end_x + kAround_px, picture.width_px);
  const int y0 = std::max(region.min_y - kAround_px, 0),
            y1 = std::min(region.last_y + 1 + kAround_px, picture.height_px);
  EXPECTS(x1 - x0 >= 3 && y1 - y0 >= 3);
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
  const double rise = kRisePerNoise * noise_lsb;
  const double floor = std::max(kFloorShare * contrast, kFloorPerNoise * noise_lsb);
  // Without branches but for the rim: most of what is measured here is noise, and no processor foresees noise.
  const int ox = (x0 + x1) / 2, oy = (y0 + y1) / 2;
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
    const auto add = [&](int x, double weight) {
      const int dx = x - ox;
      row_s += weight, row_x += weight * dx, row_xx += weight * dx * dx;
    };
    add(x0, weight_at(x0, x0 + 1));
    for (int x = x0 + 1; x < x1 - 1; ++x) add(x, weight_at(x, x));
    add(x1 - 1, weight_at(x1 - 1, x1 - 2));
    const int dy = y - oy;
    s += row_s, sx += row_x, sxx += row_xx;
    sy += row_s * dy, sxy += row_x * dy, syy += row_s * dy * dy;
  }
  if (s <= 0) return false;
  const double x = sx / s, y = sy / s;
  m.area_px2 = s / contrast;
  m.x_px = ox + x, m.y_px = oy + y;
  m.xx_px2 = sxx / s - x * x, m.xy_px2 = sxy / s - x * y, m.yy_px2 = syy / s - y * y;
  widen_to_a_pixel(m);
  return true;
}

bool measure_blob(const ImageView& picture, const Region& region, double noise_lsb, Moments& m) noexcept {
  m = outline_moments(region);
  if (!fills_its_ellipse(m)) return false;
  if (region.area_px >= kGreyMomentsBelow_px2) return true;
  Moments grey;
  if (!measure_darkness(picture, region, noise_lsb, grey)) return false;
  // A neighbour that reaches into the box spoils grey moments; then the outline's own are the better ones.
  const bool agrees = std::hypot(grey.x_px - m.x_px, grey.y_px - m.y_px) < kPulled * std::sqrt(m.area_px2) &&
                      grey.xx_px2 < kWidened * m.xx_px2 + kWidened_px2 &&
                      grey.yy_px2 < kWidened * m.yy_px2 + kWidened_px2;
  if (agrees) grey.area_px2 = m.area_px2, m = grey;
  return true;
}

}  // namespace ninedot
