#include "detect/blob_moments.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <opencv2/core/hal/intrin.hpp>
#include <utility>

#include "base/contract.h"
#include "image/vector_operators.h"

// Variances are E[x^2] - E[x]^2 with x counted from the middle of the box, an integer. Counted from the picture's
// corner both terms are up to 10^6 times as large as their difference, and for a single pixel rounding decides its
// sign.

namespace ninedot {
namespace {

// Moments of grey levels are worth their time for small blobs only: at 12 px diameter an outline of whole pixels, 38 of
// them with an error of 0.3 px each, has its centroid right to 0.07 px, and what reads blobs needs no better.
constexpr int kGreyMomentsBelow_px2 = 120;
constexpr int kAround_px = 2;    // around the box of a region: where half the darkness is not reached but some is
constexpr int kBoxSide_px = 64;  // the largest region that may be a dot (blob_finder.cpp), and what is around it
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

/// Sums over a box of darkness [LSB], times its place against some pixel and products of that [px, px^2].
struct DarknessSums {
  double s, x, y, xx, xy, yy;
};

/// The pixels around a region, copied so that vectors may reach over a row's end: there it is as bright as can be.
class Box {
 public:
  Box(const ImageView& picture, int x0, int y0, int width, int height) noexcept : width_(width), height_(height) {
    const cv::v_uint8x16 bright = cv::v_setall_u8(kBright);
    cv::v_uint8x16 darkest = bright;
    for (int y = 0; y < height; ++y) {
      std::uint8_t* to = row(y);
      cv::v_store_aligned(to + (width - 1) / kBytes * kBytes, bright);
      std::memcpy(to, picture.row(y0 + y) + x0, static_cast<std::size_t>(width));
      for (int x = 0; x < width; x += kBytes) darkest = cv::v_min(darkest, cv::v_load_aligned(to + x));
      rim_sum_lsb_ += to[0] + to[width - 1];
    }
    const std::uint8_t *first = row(0), *last = row(height - 1);
    for (int x = 1; x + 1 < width; ++x) rim_sum_lsb_ += first[x] + last[x];
    darkest_lsb_ = cv::v_reduce_min(darkest);
  }

  int rim_sum_lsb() const noexcept { return rim_sum_lsb_; }
  int rim_count() const noexcept { return 2 * (width_ + height_) - 4; }
  int darkest_lsb() const noexcept { return darkest_lsb_; }

  /// What gets darker again further out is something else: another dot, the wall beyond the sheet. Only on the rim a
  /// pixel's neighbour nearer to the region is another than itself.
  void leave_out_what_darkens_outwards(int rise_lsb) noexcept {
    const auto look_at = [=](std::uint8_t& pixel, std::uint8_t nearer) {
      pixel = nearer - pixel > rise_lsb ? kBright : pixel;
    };
    for (const auto& [y, next] : {std::pair(0, 1), std::pair(height_ - 1, height_ - 2)}) {
      std::uint8_t* outer = row(y);
      const std::uint8_t* nearer = row(next);
      look_at(outer[0], nearer[1]);
      for (int x = 1; x + 1 < width_; ++x) look_at(outer[x], nearer[x]);
      look_at(outer[width_ - 1], nearer[width_ - 2]);
    }
    for (int y = 1; y + 1 < height_; ++y) {
      std::uint8_t* pixels = row(y);
      look_at(pixels[0], pixels[1]);
      look_at(pixels[width_ - 1], pixels[width_ - 2]);
    }
  }

  /// Of the pixels that are no brighter than `brightest_lsb` [LSB], against the rim's mean.
  /// \param dx0, dy0  place of the first pixel [px]
  DarknessSums sum_darkness(int brightest_lsb, int dx0, int dy0) const noexcept {
    // Darkness in parts of a grey level: exact, unless the rim is so long that it would not fit.
    const int per_lsb = std::min(rim_count(), 128);
    const cv::v_int16x8 scale = cv::v_setall_s16(static_cast<short>(per_lsb)),
                        paper = cv::v_setall_s16(static_cast<short>(rim_sum_lsb_ * per_lsb / rim_count())),
                        limit = cv::v_setall_s16(static_cast<short>(brightest_lsb + 1)), ones = cv::v_setall_s16(1),
                        step = cv::v_setall_s16(kWords);
    const auto first = static_cast<short>(dx0);
    const cv::v_int16x8 first_dx = cv::v_add_wrap(cv::v_setall_s16(first), cv::v_int16x8(0, 1, 2, 3, 4, 5, 6, 7));
    const cv::v_float32x4 one = cv::v_setall_f32(1);
    cv::v_float32x4 s = cv::v_setzero_f32(), x = s, y = s, xx = s, xy = s, yy = s;
    for (int v = 0; v < height_; ++v) {
      const std::uint8_t* pixels = row(v);
      cv::v_int32x4 row_s = cv::v_setzero_s32(), row_x = row_s, row_xx = row_s;
      cv::v_int16x8 dx = first_dx;
      for (int u = 0; u < width_; u += kWords) {
        const cv::v_int16x8 grey = cv::v_reinterpret_as_s16(cv::v_load_expand(pixels + u));
        // Lanes that count are -1, and so is the sign of what they are multiplied by.
        const cv::v_int16x8 darkness =
            cv::v_mul_wrap(less(grey, limit), cv::v_sub_wrap(cv::v_mul_wrap(grey, scale), paper));
        row_s = cv::v_dotprod(darkness, ones, row_s);
        row_x = cv::v_dotprod(darkness, dx, row_x);
        row_xx = cv::v_dotprod(darkness, cv::v_mul_wrap(dx, dx), row_xx);
        dx = cv::v_add_wrap(dx, step);
      }
      const cv::v_float32x4 dy = cv::v_setall_f32(static_cast<float>(dy0 + v)), sum = cv::v_cvt_f32(row_s),
                            sum_x = cv::v_cvt_f32(row_x), sum_y = cv::v_muladd(sum, dy, cv::v_setzero_f32());
      s = cv::v_muladd(sum, one, s);
      x = cv::v_muladd(sum_x, one, x);
      xx = cv::v_muladd(cv::v_cvt_f32(row_xx), one, xx);
      y = cv::v_muladd(sum_y, one, y);
      xy = cv::v_muladd(sum_x, dy, xy);
      yy = cv::v_muladd(sum_y, dy, yy);
    }
    const auto total = [&](const cv::v_float32x4& lanes) {
      return static_cast<double>(cv::v_reduce_sum(lanes)) / per_lsb;
    };
    return {total(s), total(x), total(y), total(xx), total(xy), total(yy)};
  }

 private:
  static constexpr int kBytes = 16, kWords = 8;  // of a vector
  static constexpr std::uint8_t kBright = 255;
  std::uint8_t* row(int y) noexcept { return &pixels_[static_cast<std::size_t>(y * kBoxSide_px)]; }
  const std::uint8_t* row(int y) const noexcept { return &pixels_[static_cast<std::size_t>(y * kBoxSide_px)]; }

  int width_, height_, rim_sum_lsb_ = 0, darkest_lsb_ = kBright;
  alignas(16) std::array<std::uint8_t, kBoxSide_px * kBoxSide_px> pixels_;  // as many as are there are set
};

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
  EXPECTS(x1 - x0 >= 3 && y1 - y0 >= 3 && x1 - x0 <= kBoxSide_px && y1 - y0 <= kBoxSide_px);
  Box box(picture, x0, y0, x1 - x0, y1 - y0);
  const double paper_lsb = static_cast<double>(box.rim_sum_lsb()) / box.rim_count();
  const double contrast_lsb = paper_lsb - box.darkest_lsb();
  if (contrast_lsb <= 0) return false;
  box.leave_out_what_darkens_outwards(static_cast<int>(std::min(kRisePerNoise * noise_lsb, 255.0)));
  const double floor_lsb = std::max(kFloorShare * contrast_lsb, kFloorPerNoise * noise_lsb);
  const auto brightest_lsb = static_cast<int>(std::floor(paper_lsb - floor_lsb));
  const int ox = (x0 + x1) / 2, oy = (y0 + y1) / 2;
  const DarknessSums sums = box.sum_darkness(brightest_lsb, x0 - ox, y0 - oy);
  if (sums.s <= 0) return false;
  const double x = sums.x / sums.s, y = sums.y / sums.s;
  m.area_px2 = sums.s / contrast_lsb;
  m.x_px = ox + x, m.y_px = oy + y;
  m.xx_px2 = sums.xx / sums.s - x * x, m.xy_px2 = sums.xy / sums.s - x * y, m.yy_px2 = sums.yy / sums.s - y * y;
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
