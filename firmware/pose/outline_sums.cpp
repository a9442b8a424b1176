#include "pose/outline_sums.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/vector_clones.h"

// Sums of products of all columns, pixels in the nearest cache; then Gaussian elimination of the group's own columns:
// the light's from the end, then the pattern's at the beginning. Only lower triangles are kept.

namespace ninedot {
namespace {

/// Fewer pixels beyond the group's own unknowns leave no variance to speak of.
constexpr int kLeastFreedom = 4;
/// Pixels' worth of paper and of ink, below which one of them is not in sight.
constexpr double kLeastPaper_px2 = 0.5, kLeastInk_px2 = 0.3;
/// A whole dot of 2.2 px has 0.6 through a blur of a pixel, and a half of that while blur and offset are on their way.
constexpr double kLeastWholeInk_px2 = 0.1;
/// What the pixels say nothing of stays zero: a thousandth of a pixel that says so.
constexpr double kRidge_px2 = 1e-3;
/// Prior of the pattern: 1-sigma of what an interpolation by neighbours leaves in luma, in any ink (0.05 to 0.1).
/// [px^2]
constexpr double kPatternSigma_px2 = 0.1;
/// A dot that is one group has no more pixels, unless it is seen from far aside.
constexpr std::size_t kMostOfEdgedDot = 1024;
constexpr double kRounding_lsb2 = 1.0 / 12;   // of whole grey levels
constexpr std::size_t kVectorAlignment = 16;  // [B]

double square(double x) noexcept { return x * x; }

/// Sums of products of columns: everything that a step needs. Lower triangle.
using ProductSums = std::array<std::array<double, kColumns>, kColumns>;

/// Some columns, one after another.
struct ColumnRange {
  std::size_t first, end;
};

/// Eight lanes as one: of a sum over an array of lanes GCC makes no vector.
using LaneVector [[gnu::vector_size(sizeof(Lanes)), gnu::aligned(kVectorAlignment), gnu::may_alias]] = float;
const LaneVector& as_vector(const Lanes& lanes) noexcept { return *reinterpret_cast<const LaneVector*>(lanes.data()); }

using FourSums [[gnu::vector_size(4 * sizeof(float))]] = float;
using FourTotals [[gnu::vector_size(4 * sizeof(double)), gnu::aligned(alignof(double)), gnu::may_alias]] = double;

/// Neighbours first, in an order that is the same whatever the vectors' width.
float total(const LaneVector& lanes) noexcept {
  const auto pairs =
      __builtin_shufflevector(lanes, lanes, 0, 2, 4, 6) + __builtin_shufflevector(lanes, lanes, 1, 3, 5, 7);
  const auto halves =
      __builtin_shufflevector(pairs, pairs, 0, 2, 0, 2) + __builtin_shufflevector(pairs, pairs, 1, 3, 1, 3);
  return halves[0] + halves[1];
}
/// Of four at once, each to the bit as it is alone: a product does not depend on what else is asked.
FourSums totals(const LaneVector& a, const LaneVector& b, const LaneVector& c, const LaneVector& d) noexcept {
  const auto ab = __builtin_shufflevector(a, b, 0, 2, 8, 10, 4, 6, 12, 14) +
                  __builtin_shufflevector(a, b, 1, 3, 9, 11, 5, 7, 13, 15);
  const auto cd = __builtin_shufflevector(c, d, 0, 2, 8, 10, 4, 6, 12, 14) +
                  __builtin_shufflevector(c, d, 1, 3, 9, 11, 5, 7, 13, 15);
  const auto fours = __builtin_shufflevector(ab, cd, 0, 2, 8, 10, 4, 6, 12, 14) +
                     __builtin_shufflevector(ab, cd, 1, 3, 9, 11, 5, 7, 13, 15);
  return __builtin_shufflevector(fours, fours, 0, 1, 2, 3) + __builtin_shufflevector(fours, fours, 4, 5, 6, 7);
}

/// Adds the products of `rows` with `columns`, or with those of themselves that do not come after them, of so many
/// batches: as a constant it leaves each product one run of instructions.
template <std::size_t kBatches, bool kWithThemselves>
void add_products(const ColumnBatches& batches, ColumnRange rows, ColumnRange columns, ProductSums& sums) noexcept {
  for (std::size_t i = rows.first; i < rows.end; ++i) {
    const std::size_t end = kWithThemselves ? i + 1 : columns.end;
    std::size_t j = columns.first;
    for (; j + 4 <= end; j += 4) {
      LaneVector a{}, b{}, c{}, d{};
      for (std::size_t batch = 0; batch < kBatches; ++batch) {
        const OutlineColumns& some = batches[batch];
        const LaneVector row = as_vector(some[i]);
        a += row * as_vector(some[j]), b += row * as_vector(some[j + 1]);
        c += row * as_vector(some[j + 2]), d += row * as_vector(some[j + 3]);
      }
      reinterpret_cast<FourTotals&>(sums[i][j]) += __builtin_convertvector(totals(a, b, c, d), FourTotals);
    }
    for (; j < end; ++j) {
      LaneVector sum{};
      for (std::size_t batch = 0; batch < kBatches; ++batch)
        sum += as_vector(batches[batch][i]) * as_vector(batches[batch][j]);
      sums[i][j] += static_cast<double>(total(sum));
    }
  }
}

template <bool kWithThemselves, std::size_t... kBefore>
void add_products(std::size_t count, const ColumnBatches& batches, ColumnRange rows, ColumnRange columns,
                  ProductSums& sums, std::index_sequence<kBefore...> /*unused*/) noexcept {
  ((count == kBefore + 1 ? add_products<kBefore + 1, kWithThemselves>(batches, rows, columns, sums) : void()), ...);
}

/// Of the first `count` batches, 1 to kMaxBatches: the products of `rows` among themselves.
NINEDOT_VECTOR_CLONES
void add_squares(std::size_t count, const ColumnBatches& batches, ColumnRange rows, ProductSums& sums) noexcept {
  add_products<true>(count, batches, rows, rows, sums, std::make_index_sequence<kMaxBatches>());
}
/// Likewise of `rows` with `columns`.
NINEDOT_VECTOR_CLONES
void add_mixed(std::size_t count, const ColumnBatches& batches, ColumnRange rows, ColumnRange columns,
               ProductSums& sums) noexcept {
  add_products<false>(count, batches, rows, columns, sums, std::make_index_sequence<kMaxBatches>());
}

/// The grey levels that fit a group best, less its first pixel's.
struct OwnLight {
  double paper_lsb = 0, ink_lsb = 0;
};

/// The lower triangle of sums, from which the group's own columns are eliminated.
template <bool kWithPattern>
class Elimination {
 public:
  /// \param first  of the columns that are asked for, beside the pattern's; kWithPattern: these are in the sums as well
  Elimination(ProductSums& sums, std::size_t first, std::size_t end) noexcept : S_(sums), first_(first), end_(end) {
    for (std::size_t i = kBeyondColumn; i < end; ++i) S_[i][i] += kRidge_px2;
  }

  /// Takes the light's columns out, the last first. \return false: they do not determine it
  bool eliminate_light(OwnLight& light) noexcept {
    // Among themselves first; then out of all others at once, which are read and written once.
    double ink_per_paper = 0;
    for (std::size_t k = end_ - 1; k >= kPaperColumn; --k) {
      if (!(S_[k][k] > 0)) return false;
      const double inverse = 1 / S_[k][k];
      for (std::size_t i = kPaperColumn; i < k; ++i) {
        const double factor = S_[k][i] * inverse;
        if constexpr (kWithPattern)
          for (std::size_t j = 0; j < kPatternColumns; ++j) S_[i][j] -= factor * S_[k][j];
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
      case 6:
        take_out<6>();
        break;
      case 8:
        take_out<8>();
        break;
      default:
        take_out<5>();
        break;
    }
    return true;
  }

  /// Then the pattern's, as far as the pixels say more of it than its prior does. \return freedoms that it took
  double eliminate_pattern(double contrast_lsb, int degrees_of_freedom) noexcept {
    const double variance_lsb2 = std::max(S_[kGreyColumn][kGreyColumn] / degrees_of_freedom, kRounding_lsb2);
    const double ridge = variance_lsb2 / square(contrast_lsb * kPatternSigma_px2);
    double freedoms = 0;
    for (std::size_t k = 0; k < kPatternColumns; ++k) {
      const double pivot = S_[k][k] + ridge;
      freedoms += S_[k][k] / pivot;
      const auto take_from = [&](std::size_t i) {
        const double factor = S_[i][k] / pivot;
        for (std::size_t j = k + 1; j < std::min(i + 1, kPatternColumns); ++j) S_[i][j] -= factor * S_[j][k];
        for (std::size_t j = std::max(first_, kPatternColumns); j <= i; ++j) S_[i][j] -= factor * S_[j][k];
      };
      for (std::size_t i = k + 1; i < kPatternColumns; ++i) take_from(i);
      for (std::size_t i = first_; i <= kGreyColumn; ++i) take_from(i);
    }
    return freedoms;
  }

 private:
  template <std::size_t kOwn>
  void take_out() noexcept {
    if constexpr (kWithPattern)
      for (std::size_t i = 0; i < kPatternColumns; ++i) take_out_of_row<kOwn>(i);
    for (std::size_t i = first_; i <= kGreyColumn; ++i) take_out_of_row<kOwn>(i);
  }

  template <std::size_t kOwn>
  void take_out_of_row(std::size_t i) noexcept {
    std::array<double, kOwn> factor;
    for (std::size_t k = 0; k < kOwn; ++k) factor[k] = S_[kPaperColumn + k][i] / S_[kPaperColumn + k][kPaperColumn + k];
    const auto take_from = [&](std::size_t first, std::size_t end) {
      for (std::size_t j = first; j < end; ++j) {
        double left = S_[i][j];
        for (std::size_t k = 0; k < kOwn; ++k) left -= factor[k] * S_[kPaperColumn + k][j];
        S_[i][j] = left;
      }
    };
    if constexpr (kWithPattern) take_from(0, std::min(i + 1, kPatternColumns));
    take_from(first_, i + 1);
  }

  ProductSums& S_;
  std::size_t first_, end_;
};

/// \return  false: the group's columns do not determine its light
template <bool kWithPattern>
bool eliminate_own(ProductSums& sums, std::size_t first, std::size_t end, OwnLight& light, GroupFit& fit) noexcept {
  Elimination<kWithPattern> elimination(sums, first, end);
  if (!elimination.eliminate_light(light)) return false;
  fit.contrast_lsb = light.paper_lsb - light.ink_lsb;
  if constexpr (kWithPattern)
    fit.degrees_of_freedom -=
        static_cast<int>(std::lround(elimination.eliminate_pattern(fit.contrast_lsb, fit.degrees_of_freedom)));
  return true;
}

/// What is left says how the outline moves, for a contrast of 1: times the contrast it is the normal equations.
void take_normal(const ProductSums& left, bool has_tone, GroupFit& fit) noexcept {
  // A row of the sums' lower triangle is a column of the upper one.
  using Square = Eigen::Matrix<double, kToneUnknown, kToneUnknown>;
  using Upper = Eigen::Map<const Square, Eigen::Unaligned, Eigen::OuterStride<kColumns>>;
  using Row = Eigen::Map<const Eigen::Matrix<double, kToneUnknown, 1>>;
  using Column =
      Eigen::Map<const Eigen::Matrix<double, kToneUnknown, 1>, Eigen::Unaligned, Eigen::InnerStride<kColumns>>;
  const double contrast2_lsb2 = fit.contrast_lsb * fit.contrast_lsb;
  fit.normal.topLeftCorner<kToneUnknown, kToneUnknown>() = contrast2_lsb2 * Upper(&left[kStateColumn][kStateColumn]);
  fit.normal.col(kToneUnknown).setZero();
  fit.gradient.head<kToneUnknown>() = fit.contrast_lsb * Row(&left[kGreyColumn][kStateColumn]);
  fit.gradient(kToneUnknown) = 0;
  if (has_tone) {
    fit.normal.col(kToneUnknown).head<kToneUnknown>() = contrast2_lsb2 * Column(&left[kStateColumn][kToneColumn]);
    fit.normal(kToneUnknown, kToneUnknown) = contrast2_lsb2 * left[kToneColumn][kToneColumn];
    fit.gradient(kToneUnknown) = fit.contrast_lsb * left[kGreyColumn][kToneColumn];
  }
  for (Eigen::Index i = 1; i < kUnknowns; ++i)
    for (Eigen::Index j = 0; j < i; ++j) fit.normal(i, j) = fit.normal(j, i);
  fit.shift_information = fit.normal(6, 6);
  fit.usable = fit.shift_information > 0;
  fit.shift_px = fit.usable ? fit.gradient(6) / fit.shift_information : 0;
}

}  // namespace

void GroupFitter::look_at(const OutlineGroup& group) noexcept {
  if (dot_ == group.dot) return;
  dot_ = group.dot;
  look_.emplace(pixels_, landmark_, state_, dot_, asked_);
  if (pixels_.has_pattern && group.whole_dot)
    before_interpolation_.emplace(pixels_, landmark_, before_interpolation(state_), dot_, Asked::kState);
}

std::optional<LightEdge> GroupFitter::find_edge(const OutlineGroup& group, const LightEdge* start) noexcept {
  const auto first = static_cast<std::size_t>(group.first), count = static_cast<std::size_t>(group.count);
  if (count > kMostOfEdgedDot) return std::nullopt;
  look_at(group);
  using Column = std::array<Lanes, kMostOfEdgedDot / kLanes>;
  Column ink_share, outside{}, outward_x_px{}, outward_y_px{};
  alignas(kVectorAlignment) ColumnBatches batches;
  for (std::size_t at = 0; at < count; at += kLanes * kMaxBatches) {
    const std::size_t used = std::min(kLanes * kMaxBatches, count - at);
    fill_columns(pixels_, group, look_->view, look_->disc, {first + at, used, 1}, Asked::kLightOnly, batches);
    for (std::size_t batch = 0; batch * kLanes < used; ++batch)
      ink_share[at / kLanes + batch] = batches[batch][kInkColumn];
  }
  if (!look_->disc.is_small())
    look_outward(pixels_, look_->view, {first, count, 1}, outside, outward_x_px, outward_y_px);
  const auto of_group = [&](const std::vector<float>& column) { return std::span(column).subspan(first, count); };
  const auto as_floats = [&](const Column& column) { return std::span(column.front().data(), count); };
  return find_light_edge(
      {of_group(pixels_.x_px), of_group(pixels_.y_px), of_group(pixels_.luma), as_floats(ink_share), as_floats(outside),
       as_floats(outward_x_px), as_floats(outward_y_px), static_cast<double>(pixels_.lit_ink())},
      start);
}

void GroupFitter::fit(const OutlineGroup& group, GroupFit& fit, std::size_t every) noexcept {
  fit.usable = false;
  fit.light_px2 = 0;
  const bool has_edge = group.whole_dot && pixels_.light_edges[group.dot];
  // Paper, ink, beyond, two slopes, beyond's change along the side; of an edge two levels and three of its own.
  const std::size_t own = has_edge              ? 8
                          : group.whole_dot     ? (group.at_paper_edge && pixels_.regards_walls ? 6 : 5)
                          : group.at_paper_edge ? 3
                                                : 2;
  const std::size_t count = (static_cast<std::size_t>(group.count) + every - 1) / every;
  const bool beyond_is_empty = group.whole_dot && !group.at_paper_edge;
  fit.degrees_of_freedom = static_cast<int>(count) - static_cast<int>(own) + (beyond_is_empty ? 1 : 0);
  if (fit.degrees_of_freedom < kLeastFreedom) return;

  // Stretches of long outlines meet the pattern everywhere. Thinned pixels show one half of it.
  const bool with_pattern = pixels_.has_pattern && group.whole_dot && every == 1 &&
                            fit.degrees_of_freedom >= kLeastFreedom + static_cast<int>(kPatternColumns);
  if (has_edge) fit.light_px2 = square(pixels_.light_edges[group.dot]->moves_px);
  look_at(group);
  const bool with_tone = asked_ == Asked::kState && pixels_.has_tone;
  const std::size_t first = asked_ == Asked::kLightOnly ? kGreyColumn : with_tone ? kToneColumn : kStateColumn;
  const std::size_t end = kPaperColumn + own;
  const ColumnRange asked{first, end};
  constexpr ColumnRange kPattern{0, kPatternColumns};
  ProductSums sums;
  for (std::size_t i = first; i < end; ++i) std::fill_n(&sums[i][first], end - first, 0.0);
  if (with_pattern)
    for (std::array<double, kColumns>& row : sums) std::fill_n(row.begin(), kPatternColumns, 0.0);
  alignas(kVectorAlignment) ColumnBatches batches;
  for (std::size_t at = 0; at < count; at += kLanes * kMaxBatches) {
    const std::size_t used = std::min(kLanes * kMaxBatches, count - at);
    const PixelRange range{static_cast<std::size_t>(group.first) + at * every, used, every};
    fill_columns(pixels_, group, look_->view, look_->disc, range, asked_, batches);
    if (pixels_.are_smeared && group.whole_dot)
      for (std::size_t i = 0; i < used; ++i)
        batches[i / kLanes][kGreyColumn][i % kLanes] += pixels_.ink_of_others_lsb[range.first + i * every];
    if (with_pattern)
      fill_pattern_columns(pixels_, before_interpolation_->view, before_interpolation_->disc, range, batches);
    const std::size_t filled = (used + kLanes - 1) / kLanes;
    add_squares(filled, batches, asked, sums);
    if (!with_pattern) continue;
    add_squares(filled, batches, kPattern, sums);
    add_mixed(filled, batches, asked, kPattern, sums);
  }
  if (sums[kPaperColumn][kPaperColumn] < kLeastPaper_px2 ||
      sums[kInkColumn][kInkColumn] < (group.whole_dot ? kLeastWholeInk_px2 : kLeastInk_px2))
    return;

  OwnLight light;
  const bool is_determined = with_pattern ? eliminate_own<true>(sums, first, end, light, fit)
                                          : eliminate_own<false>(sums, first, end, light, fit);
  if (!is_determined) return;
  fit.paper_lsb = light.paper_lsb + static_cast<double>(pixels_.luma[static_cast<std::size_t>(group.first)]);
  fit.squared_residuals = std::max(sums[kGreyColumn][kGreyColumn], 0.0);
  fit.usable = std::isfinite(fit.squared_residuals);
  if (asked_ != Asked::kLightOnly && fit.usable) take_normal(sums, with_tone, fit);
}

}  // namespace ninedot
