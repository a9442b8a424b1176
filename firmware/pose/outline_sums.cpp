#include "pose/outline_sums.h"

#include <algorithm>
#include <cmath>
#include <opencv2/core/hal/intrin.hpp>

// Sums of products of all columns in one pass over the pixels; then Gaussian elimination of the group's own columns
// from the end. Only lower triangles are kept.

namespace ninedot {
namespace {

/// Fewer pixels beyond the group's own unknowns leave no variance to speak of.
constexpr int kLeastFreedom = 4;
/// Pixels' worth of paper and of ink, below which one of them is not in sight.
constexpr double kLeastPaper_px2 = 0.5, kLeastInk_px2 = 0.3;
/// What the pixels say nothing of stays zero: a thousandth of a pixel that says so.
constexpr double kRidge_px2 = 1e-3;

/// Sums of products of all columns: everything that a step needs.
class ProductSums {
 public:
  /// Adds the products of the columns [first, end) with each other.
  void add(const OutlineColumns& columns, std::size_t first, std::size_t end) noexcept {
    for (std::size_t i = first; i < end; ++i) {
      std::size_t pair = i * (i + 1) / 2 + first;
      const float* a = columns[i].data();
      const cv::v_float32x4 a0 = cv::v_load_aligned(a), a1 = cv::v_load_aligned(a + 4);
      for (std::size_t j = first; j <= i; ++j, ++pair) {
        const float* b = columns[j].data();
        float* to = sum_[pair].data();
        cv::v_float32x4 s = cv::v_muladd(a0, cv::v_load_aligned(b), cv::v_load_aligned(to));
        s = cv::v_muladd(a1, cv::v_load_aligned(b + 4), s);
        cv::v_store_aligned(to, s);
      }
    }
  }
  /// \param i  at least j
  double operator()(std::size_t i, std::size_t j) const noexcept {
    const auto& s = sum_[i * (i + 1) / 2 + j];
    return static_cast<double>((s[0] + s[1]) + (s[2] + s[3]));
  }

 private:
  alignas(16) std::array<std::array<float, 4>, kColumns*(kColumns + 1) / 2> sum_{};
};

/// The grey levels that fit a group best, less its first pixel's.
struct OwnLight {
  double paper_lsb = 0, ink_lsb = 0;
};

/// The lower triangle of sums, from which columns are eliminated from the end.
class Elimination {
 public:
  Elimination(const ProductSums& sums, std::size_t first, std::size_t end) noexcept : first_(first), end_(end) {
    for (std::size_t i = first; i < end; ++i)
      for (std::size_t j = first; j <= i; ++j) S_[i][j] = sums(i, j);
    for (std::size_t i = kBeyondColumn; i < end; ++i) S_[i][i] += kRidge_px2;
  }

  /// Takes the group's own columns out. \return false: they do not determine its light
  bool eliminate_own(OwnLight& light) noexcept {
    double ink_per_paper = 0;
    for (std::size_t k = end_ - 1; k >= kPaperColumn; --k) {
      if (!(S_[k][k] > 0)) return false;
      const double inverse = 1 / S_[k][k];
      if (k == kInkColumn) light.ink_lsb = S_[k][kGreyColumn] * inverse, ink_per_paper = S_[k][kPaperColumn] * inverse;
      if (k == kPaperColumn) light.paper_lsb = S_[k][kGreyColumn] * inverse;
      for (std::size_t i = first_; i < k; ++i) {
        const double factor = S_[k][i] * inverse;
        for (std::size_t j = first_; j <= i; ++j) S_[i][j] -= factor * S_[k][j];
      }
    }
    light.ink_lsb -= ink_per_paper * light.paper_lsb;
    return true;
  }

  double operator()(std::size_t i, std::size_t j) const noexcept { return S_[i][j]; }

 private:
  std::size_t first_, end_;
  std::array<std::array<double, kColumns>, kColumns> S_;
};

/// What is left says how the outline moves, for a contrast of 1: times the contrast it is the normal equations.
void take_normal(const Elimination& left, GroupFit& fit) noexcept {
  const double contrast2 = fit.contrast_lsb * fit.contrast_lsb;
  for (std::size_t i = 0; i < kUnknowns; ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    fit.gradient(row) = left(kGreyColumn, i) * fit.contrast_lsb;
    for (std::size_t j = 0; j <= i; ++j) {
      const auto column = static_cast<Eigen::Index>(j);
      fit.normal(row, column) = fit.normal(column, row) = left(i, j) * contrast2;
    }
  }
  fit.shift_information = fit.normal(6, 6);
  fit.usable = fit.shift_information > 0;
  fit.shift_px = fit.usable ? fit.gradient(6) / fit.shift_information : 0;
}

}  // namespace

void fit_group(const OutlinePixels& pixels, const OutlineGroup& group, const LandmarkGeometry& landmark,
               const OutlineState& state, Asked asked, GroupFit& fit) noexcept {
  fit.usable = false;
  const std::size_t own = group.whole_dot ? 5 : group.at_paper_edge ? 3 : 2;  // paper, ink, beyond, two slopes
  fit.degrees_of_freedom = group.count - 2 - (group.whole_dot ? 2 : 0) - (group.at_paper_edge ? 1 : 0);
  if (fit.degrees_of_freedom < kLeastFreedom) return;

  const std::size_t first = asked == Asked::kLightOnly ? kGreyColumn : 0, end = kPaperColumn + own;
  const DotView view(pixels, landmark, state, group.dot);
  ProductSums sums;
  alignas(16) ColumnBatches batches;
  const auto count = static_cast<std::size_t>(group.count);
  for (std::size_t at = 0; at < count; at += kLanes * kMaxBatches) {
    const std::size_t used = std::min(kLanes * kMaxBatches, count - at);
    fill_columns(pixels, group, view, static_cast<std::int32_t>(at), used, batches);
    if (asked == Asked::kShape) turn_to_shape(pixels, group, view, static_cast<std::int32_t>(at), used, batches);
    for (std::size_t batch = 0; batch * kLanes < used; ++batch) sums.add(batches[batch], first, end);
  }
  if (sums(kPaperColumn, kPaperColumn) < kLeastPaper_px2 || sums(kInkColumn, kInkColumn) < kLeastInk_px2) return;

  Elimination left(sums, first, end);
  OwnLight light;
  if (!left.eliminate_own(light)) return;
  fit.paper_lsb = light.paper_lsb + static_cast<double>(pixels.luma[static_cast<std::size_t>(group.first)]);
  fit.contrast_lsb = light.paper_lsb - light.ink_lsb;
  fit.squared_residuals = std::max(left(kGreyColumn, kGreyColumn), 0.0);
  fit.usable = std::isfinite(fit.squared_residuals);
  if (asked != Asked::kLightOnly && fit.usable) take_normal(left, fit);
}

}  // namespace ninedot
