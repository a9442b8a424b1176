#include "pose/outline_sums.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <opencv2/core/hal/intrin.hpp>
#include <utility>

// Sums of products of all columns, pixels in the nearest cache; then Gaussian elimination of the group's own columns
// from the end. Only lower triangles are kept.

namespace ninedot {
namespace {

/// Fewer pixels beyond the group's own unknowns leave no variance to speak of.
constexpr int kLeastFreedom = 4;
/// Pixels' worth of paper and of ink, below which one of them is not in sight.
constexpr double kLeastPaper_px2 = 0.5, kLeastInk_px2 = 0.3;
/// What the pixels say nothing of stays zero: a thousandth of a pixel that says so.
constexpr double kRidge_px2 = 1e-3;

/// Sums of products of columns: everything that a step needs. Lower triangle.
using ProductSums = std::array<std::array<double, kColumns>, kColumns>;

/// Adds the products of the columns [first, end) with each other, of so many batches: as a constant it leaves each
/// product one run of instructions.
template <std::size_t kBatches>
void add_products(const ColumnBatches& batches, std::size_t first, std::size_t end, ProductSums& sums) noexcept {
  for (std::size_t i = first; i < end; ++i) {
    const float* a = batches[0][i].data();
    for (std::size_t j = first; j <= i; ++j) {
      const float* b = batches[0][j].data();
      cv::v_float32x4 sum = cv::v_setzero_f32();
      for (std::size_t half = 0; half < 2 * kBatches; ++half) {
        const std::size_t at = half / 2 * (kColumns * kLanes) + half % 2 * (kLanes / 2);
        sum = cv::v_muladd(cv::v_load_aligned(a + at), cv::v_load_aligned(b + at), sum);
      }
      sums[i][j] += static_cast<double>(cv::v_reduce_sum(sum));
    }
  }
}

using AddProducts = void (*)(const ColumnBatches&, std::size_t, std::size_t, ProductSums&) noexcept;
template <std::size_t... kCounts>
constexpr std::array<AddProducts, sizeof...(kCounts)> all_add_products(std::index_sequence<kCounts...>) noexcept {
  return {&add_products<kCounts + 1>...};
}
constexpr auto kAddProducts = all_add_products(std::make_index_sequence<kMaxBatches>());

/// The grey levels that fit a group best, less its first pixel's.
struct OwnLight {
  double paper_lsb = 0, ink_lsb = 0;
};

/// The lower triangle of sums, from which the group's own columns are eliminated.
class Elimination {
 public:
  Elimination(ProductSums& sums, std::size_t first, std::size_t end) noexcept : S_(sums), first_(first), end_(end) {
    for (std::size_t i = kBeyondColumn; i < end; ++i) S_[i][i] += kRidge_px2;
  }

  /// Takes the group's own columns out, the last first. \return false: they do not determine its light
  bool eliminate_own(OwnLight& light) noexcept {
    // Among themselves first; then out of all others at once, which are read and written once.
    double ink_per_paper = 0;
    for (std::size_t k = end_ - 1; k >= kPaperColumn; --k) {
      if (!(S_[k][k] > 0)) return false;
      const double inverse = 1 / S_[k][k];
      for (std::size_t i = kPaperColumn; i < k; ++i) {
        const double factor = S_[k][i] * inverse;
        for (std::size_t j = first_; j <= i; ++j) S_[i][j] -= factor * S_[k][j];
      }
      if (k == kInkColumn) light.ink_lsb = S_[k][kGreyColumn] * inverse, ink_per_paper = S_[k][kPaperColumn] * inverse;
      if (k == kPaperColumn) light.paper_lsb = S_[k][kGreyColumn] * inverse;
    }
    light.ink_lsb -= ink_per_paper * light.paper_lsb;
    switch (end_ - kPaperColumn) {
      case 2:
        take_out<2>();
        break;
      case 3:
        take_out<3>();
        break;
      default:
        take_out<5>();
        break;
    }
    return true;
  }

 private:
  template <std::size_t kOwn>
  void take_out() noexcept {
    for (std::size_t i = first_; i <= kGreyColumn; ++i) {
      std::array<double, kOwn> factor;
      for (std::size_t k = 0; k < kOwn; ++k)
        factor[k] = S_[kPaperColumn + k][i] / S_[kPaperColumn + k][kPaperColumn + k];
      for (std::size_t j = first_; j <= i; ++j) {
        double left = S_[i][j];
        for (std::size_t k = 0; k < kOwn; ++k) left -= factor[k] * S_[kPaperColumn + k][j];
        S_[i][j] = left;
      }
    }
  }

  ProductSums& S_;
  std::size_t first_, end_;
};

/// What is left says how the outline moves, for a contrast of 1: times the contrast it is the normal equations.
void take_normal(const ProductSums& left, GroupFit& fit) noexcept {
  // A row of the sums' lower triangle is a column of the upper one.
  using Upper = Eigen::Map<const UnknownMatrix, Eigen::Unaligned, Eigen::OuterStride<kColumns>>;
  fit.normal = fit.contrast_lsb * fit.contrast_lsb * Upper(left[0].data());
  for (Eigen::Index i = 1; i < kUnknowns; ++i)
    for (Eigen::Index j = 0; j < i; ++j) fit.normal(i, j) = fit.normal(j, i);
  fit.gradient = fit.contrast_lsb * Eigen::Map<const UnknownVector>(left[kGreyColumn].data());
  fit.shift_information = fit.normal(6, 6);
  fit.usable = fit.shift_information > 0;
  fit.shift_px = fit.usable ? fit.gradient(6) / fit.shift_information : 0;
}

}  // namespace

void GroupFitter::fit(const OutlineGroup& group, GroupFit& fit, std::size_t every) noexcept {
  fit.usable = false;
  const std::size_t own = group.whole_dot ? 5 : group.at_paper_edge ? 3 : 2;  // paper, ink, beyond, two slopes
  const std::size_t count = (static_cast<std::size_t>(group.count) + every - 1) / every;
  fit.degrees_of_freedom = static_cast<int>(count) - 2 - (group.whole_dot ? 2 : 0) - (group.at_paper_edge ? 1 : 0);
  if (fit.degrees_of_freedom < kLeastFreedom) return;

  if (!dot_ || dot_->dot != group.dot)
    dot_.emplace(
        Dot{group.dot, {pixels_, landmark_, state_, group.dot}, {pixels_, landmark_, state_, group.dot, asked_}});
  const std::size_t first = asked_ == Asked::kLightOnly ? kGreyColumn : 0, end = kPaperColumn + own;
  ProductSums sums;
  for (std::size_t i = first; i < end; ++i) sums[i] = {};
  alignas(16) ColumnBatches batches;
  for (std::size_t at = 0; at < count; at += kLanes * kMaxBatches) {
    const std::size_t used = std::min(kLanes * kMaxBatches, count - at);
    fill_columns(pixels_, group, dot_->view, dot_->disc,
                 {static_cast<std::size_t>(group.first) + at * every, used, every}, asked_, batches);
    kAddProducts[(used - 1) / kLanes](batches, first, end, sums);
  }
  if (sums[kPaperColumn][kPaperColumn] < kLeastPaper_px2 || sums[kInkColumn][kInkColumn] < kLeastInk_px2) return;

  OwnLight light;
  if (!Elimination(sums, first, end).eliminate_own(light)) return;
  fit.paper_lsb = light.paper_lsb + static_cast<double>(pixels_.luma[static_cast<std::size_t>(group.first)]);
  fit.contrast_lsb = light.paper_lsb - light.ink_lsb;
  fit.squared_residuals = std::max(sums[kGreyColumn][kGreyColumn], 0.0);
  fit.usable = std::isfinite(fit.squared_residuals);
  if (asked_ != Asked::kLightOnly && fit.usable) take_normal(sums, fit);
}

}  // namespace ninedot
