#include "detect/blob_finder.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <opencv2/core/hal/intrin.hpp>

#include "base/contract.h"

// Every level of the pyramid finds spots of 2 to about 20 of its own pixels with one small square; a dot of 130 px is a
// dot of 16 px three levels up, where the noise is an eighth. Spots become runs, runs become components by union-find,
// and components that fill the ellipse of their own moments become blobs.

namespace ninedot {
namespace {

constexpr int kMinArea_px2 = 2;             // a dot of 2.6 px diameter, blurred, may leave no more at the half level
constexpr int kMaxSide_px = 60;             // of a component at its level; larger ones are better seen a level up
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
      mask_(static_cast<std::size_t>(width_px) + 2 * ImageBuffer::kPadding_px),
      // Worst texture: a run for every second pixel. Kept to a quarter of that; noise beyond is cut, not followed.
      runs_(static_cast<std::size_t>(width_px) * static_cast<std::size_t>(height_px) / 8 + 64),
      row_start_(static_cast<std::size_t>(height_px) + 1),
      components_(runs_.size()) {
  EXPECTS(width_px < 32768 && height_px < 32768);
}

void BlobFinder::find_blobs(const ImageView& luma, Levels wanted, BlobList& blobs) noexcept {
  EXPECTS(wanted.first >= 0 && wanted.first <= wanted.last && wanted.last < kLevels);
  blobs.clear();
  noise_lsb_ = estimate_noise_lsb(luma);
  for (int i = 0; i <= wanted.last; ++i) halve(i == 0 ? luma : levels_[i - 1].view(), levels_[i]);
  for (int level = wanted.last; level >= wanted.first; --level) {
    const ImageView picture = level == 0 ? luma : levels_[level - 1].view();
    if (levels_[level].width_px() < 2 || levels_[level].height_px() < 2) continue;
    const double level_noise_lsb = noise_lsb_ / (1 << level);
    const int min_contrast = std::max(kMinContrast_lsb, static_cast<int>(kContrastPerNoise * level_noise_lsb));
    find_runs(picture, threshold_.compute(levels_[level].view(), min_contrast));
    label_components();
    collect(picture, level, level_noise_lsb, blobs);
  }
}

void BlobFinder::find_runs(const ImageView& picture, const ImageBuffer& threshold) noexcept {
  run_count_ = 0;
  const int width = picture.width_px;
  std::uint8_t* __restrict mask = mask_.data();
  for (int y = 0; y < picture.height_px; ++y) {
    row_start_[static_cast<std::size_t>(y)] = static_cast<std::int32_t>(run_count_);
    const std::uint8_t* __restrict pixels = picture.row(y);
    const std::uint8_t* __restrict limit = threshold.row(std::min(y / 2, threshold.height_px() - 1));
    const int pairs = width / 2;
    for (int i = 0; i < pairs; ++i) {
      mask[2 * i] = pixels[2 * i] < limit[i] ? 0xFF : 0;
      mask[2 * i + 1] = pixels[2 * i + 1] < limit[i] ? 0xFF : 0;
    }
    std::fill(mask + 2 * pairs, mask + width + 64, std::uint8_t{0});

    bool inside = false;
    std::int16_t begin = 0;
    for (int x = 0; x <= width; x += 64) {
      std::uint64_t bits = 0;
      for (int part = 0; part < 4; ++part)
        bits |= static_cast<std::uint64_t>(static_cast<std::uint16_t>(cv::v_signmask(cv::v_load(mask + x + 16 * part))))
                << (16 * part);
      // A set bit of `edges` is where the mask changes.
      std::uint64_t edges = bits ^ ((bits << 1) | (inside ? 1U : 0U));
      while (edges != 0) {
        const auto at = static_cast<std::int16_t>(x + std::countr_zero(edges));
        edges &= edges - 1;
        if (!inside) {
          begin = at;
        } else if (run_count_ < runs_.size()) {
          runs_[run_count_] = {begin, at, static_cast<std::int32_t>(run_count_)};
          ++run_count_;
        }
        inside = !inside;
      }
    }
  }
  row_start_[static_cast<std::size_t>(picture.height_px)] = static_cast<std::int32_t>(run_count_);
  for (int y = picture.height_px; y + 1 < static_cast<int>(row_start_.size()); ++y)
    row_start_[static_cast<std::size_t>(y) + 1] = static_cast<std::int32_t>(run_count_);
}

std::int32_t BlobFinder::root(std::int32_t i) noexcept {
  auto parent = [this](std::int32_t k) -> std::int32_t& { return runs_[static_cast<std::size_t>(k)].component; };
  while (parent(i) != i) {
    parent(i) = parent(parent(i));
    i = parent(i);
  }
  return i;
}

void BlobFinder::label_components() noexcept {
  // Join runs that touch (8-neighbours) in consecutive rows; the smaller index is the root, so roots come first below.
  for (std::size_t y = 1; y + 1 < row_start_.size(); ++y) {
    std::int32_t above = row_start_[y - 1];
    const std::int32_t above_end = row_start_[y];
    for (std::int32_t here = row_start_[y]; here < row_start_[y + 1]; ++here) {
      const Run run = runs_[static_cast<std::size_t>(here)];
      while (above < above_end && runs_[static_cast<std::size_t>(above)].end < run.begin) ++above;
      for (std::int32_t other = above; other < above_end && runs_[static_cast<std::size_t>(other)].begin <= run.end;
           ++other) {
        const std::int32_t a = root(here);
        const std::int32_t b = root(other);
        if (a < b) runs_[static_cast<std::size_t>(b)].component = a;
        if (b < a) runs_[static_cast<std::size_t>(a)].component = b;
      }
    }
  }

  component_count_ = 0;
  for (std::size_t y = 0; y + 1 < row_start_.size(); ++y) {
    for (std::int32_t i = row_start_[y]; i < row_start_[y + 1]; ++i) {
      Run& run = runs_[static_cast<std::size_t>(i)];
      // From here on `component` is an index into components_, written as its complement so that it can't be mistaken.
      if (run.component == i) {
        run.component = ~static_cast<std::int32_t>(component_count_);
        components_[component_count_++] =
            Component{0, 0, 0, 0, 0, 0, run.begin, run.end, static_cast<std::int16_t>(y), 0};
      } else {
        std::int32_t parent = run.component;
        while (parent >= 0) parent = runs_[static_cast<std::size_t>(parent)].component;
        run.component = parent;
      }
      Component& c = components_[static_cast<std::size_t>(~run.component)];
      const std::int64_t n = run.end - run.begin;
      const std::int64_t first = run.begin;
      const std::int64_t last = run.end - 1;
      const std::int64_t sum_x = n * (first + last) / 2;
      const auto squares_up_to = [](std::int64_t k) { return k * (k + 1) * (2 * k + 1) / 6; };
      const auto row = static_cast<std::int64_t>(y);
      c.area += static_cast<std::int32_t>(n);
      c.sum_x += static_cast<std::int32_t>(sum_x);
      c.sum_y += static_cast<std::int32_t>(n * row);
      c.sum_xx += squares_up_to(last) - (first > 0 ? squares_up_to(first - 1) : 0);
      c.sum_xy += sum_x * row;
      c.sum_yy += n * row * row;
      c.min_x = std::min(c.min_x, run.begin);
      c.max_x = std::max(c.max_x, run.end);
      c.max_y = static_cast<std::int16_t>(y);
    }
  }
}

namespace {

struct Moments {
  double area, x, y, xx, xy, yy;
};

/// Moments weighted by darkness, over the box and two pixels around it. The paper's level is the mean of the box's rim.
bool grey_moments(const ImageView& picture, int min_x, int max_x, int min_y, int max_y, double noise_lsb,
                  Moments& m) noexcept {
  const int x0 = std::max(min_x - 2, 0), x1 = std::min(max_x + 2, picture.width_px);
  const int y0 = std::max(min_y - 2, 0), y1 = std::min(max_y + 3, picture.height_px);
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
  const double floor = std::max(0.12 * contrast, 2 * noise_lsb);
  double s = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
  for (int y = y0; y < y1; ++y) {
    for (int x = x0; x < x1; ++x) {
      const double weight = paper - picture.at(x, y);
      if (weight < floor) continue;
      s += weight, sx += weight * x, sy += weight * y;
      sxx += weight * x * x, sxy += weight * x * y, syy += weight * y * y;
    }
  }
  if (s <= 0) return false;
  m.x = sx / s, m.y = sy / s;
  m.xx = sxx / s - m.x * m.x, m.xy = sxy / s - m.x * m.y, m.yy = syy / s - m.y * m.y;
  m.area = s / contrast;
  return true;
}

}  // namespace

void BlobFinder::collect(const ImageView& picture, int level, double noise_lsb, BlobList& blobs) const noexcept {
  const auto scale = static_cast<double>(1 << level);
  for (std::size_t i = 0; i < component_count_; ++i) {
    const Component& c = components_[i];
    const int height = c.max_y - c.min_y + 1;
    const int width = c.max_x - c.min_x;
    if (c.area < kMinArea_px2 || width > kMaxSide_px || height > kMaxSide_px) continue;
    // Level 0 keeps the small ones; above, a blob must be larger than what the level below measures better.
    if (c.min_x == 0 || c.min_y == 0 || c.max_x == picture.width_px || c.max_y == picture.height_px - 1) continue;
    const double area = c.area;
    Moments m{area, c.sum_x / area, c.sum_y / area, 0, 0, 0};
    // 1/12: each pixel is a square, not a point.
    m.xx = static_cast<double>(c.sum_xx) / area - m.x * m.x + 1.0 / 12;
    m.yy = static_cast<double>(c.sum_yy) / area - m.y * m.y + 1.0 / 12;
    m.xy = static_cast<double>(c.sum_xy) / area - m.x * m.y;
    if (!fills_its_ellipse(m.area, m.xx, m.xy, m.yy)) continue;
    if (area < kGreyMomentsBelow_px2) {
      Moments grey;
      if (!grey_moments(picture, c.min_x, c.max_x, c.min_y, c.max_y, noise_lsb, grey)) continue;
      // A neighbour that reaches into the box spoils grey moments; then the outline's own are the better ones.
      const bool agrees = std::hypot(grey.x - m.x, grey.y - m.y) < 0.25 * std::sqrt(area) && grey.xx < 2.0 * m.xx + 1 &&
                          grey.yy < 2.0 * m.yy + 1;
      if (agrees) grey.area = m.area, m = grey;
    }
    const Blob blob{static_cast<float>((m.x + 0.5) * scale - 0.5),
                    static_cast<float>((m.y + 0.5) * scale - 0.5),
                    static_cast<float>(m.area * scale * scale),
                    static_cast<float>(m.xx * scale * scale),
                    static_cast<float>(m.xy * scale * scale),
                    static_cast<float>(m.yy * scale * scale),
                    level};
    // The same dot, seen one or more levels up: the finest one replaces them all.
    bool replaced = false;
    for (std::size_t k = 0; k < blobs.size();) {
      Blob& other = blobs[k];
      const float dx = other.x_px - blob.x_px, dy = other.y_px - blob.y_px;
      const bool same = other.level > level && dx * dx + dy * dy < 0.03F * other.area_px2 &&
                        blob.area_px2 > 0.4F * other.area_px2 && blob.area_px2 < 2.5F * other.area_px2;
      if (same && replaced) {
        other = blobs[blobs.size() - 1];
        blobs.pop_back();
        continue;
      }
      if (same) {
        other = blob;
        replaced = true;
      }
      ++k;
    }
    if (!replaced && !blobs.try_push_back(blob)) return;
  }
}

}  // namespace ninedot
