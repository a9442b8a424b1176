// A curve's value is a sum of the values at the positions; the weights follow from one linear system (universal
// kriging with the kernel |h|^3, G. Matheron 1973, whose curve is a cubic spline), and so does the walk's variance.
#include "calibrate/zoom_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "base/contract.h"

namespace ninedot {
namespace {

/// fx and fy as logarithms, the centre [px], coefficients in pixels: what is added up.
using Values = Eigen::Matrix<double, kIntrinsics, 1>;

/// A camera that rounds its position to a whole number stands up to half a step beside it, evenly: 1/12 when it was
/// calibrated, and 1/12 when it is used. [steps^2]
constexpr double kRounding_steps2 = 1.0 / 6;

/// By which power of 1/f a term's effect on a pixel that stays falls: coefficient times radius^power.
constexpr std::array<double, 8> powers_of(DistortionModel model) noexcept {
  switch (model) {
    case DistortionModel::kPlumbBob:
      return {2, 4, 1, 1, 6};
    case DistortionModel::kRationalPolynomial:
      return {2, 4, 1, 1, 6, 2, 4, 6};
    case DistortionModel::kEquidistant:
      break;
  }
  return {2, 4, 6, 8};
}

/// \param unit_px  a focal length, any: keeps the numbers near 1
Values values_of(const CameraModel& camera, double unit_px) noexcept {
  Values values;
  values.head<4>() << std::log(camera.fx_px), std::log(camera.fy_px), camera.cx_px, camera.cy_px;
  for (std::size_t i = 0; i < camera.k.size(); ++i)
    values(4 + static_cast<Eigen::Index>(i)) =
        camera.k[i] * std::pow(unit_px / camera.fx_px, powers_of(camera.model)[i]);
  return values;
}

/// \param like  size and model
CameraModel camera_of(const Values& values, CameraModel like, double unit_px) noexcept {
  like.fx_px = std::exp(values(0)), like.fy_px = std::exp(values(1));
  like.cx_px = values(2), like.cy_px = values(3);
  for (std::size_t i = 0; i < like.k.size(); ++i)
    like.k[i] = values(4 + static_cast<Eigen::Index>(i)) * std::pow(like.fx_px / unit_px, powers_of(like.model)[i]);
  return like;
}

/// d(intrinsics)/d(values).
IntrinsicCovariance intrinsics_by_values(const CameraModel& camera, double unit_px) noexcept {
  IntrinsicCovariance by = IntrinsicCovariance::Identity();
  by(0, 0) = camera.fx_px, by(1, 1) = camera.fy_px;
  for (std::size_t i = 0; i < camera.k.size(); ++i) {
    const auto at = 4 + static_cast<Eigen::Index>(i);
    const double power = powers_of(camera.model)[i];
    by(at, at) = std::pow(camera.fx_px / unit_px, power);
    by(at, 0) = power * camera.k[i];
  }
  return by;
}

/// How a curve's value comes about.
struct Weights {
  Eigen::VectorXd of;   // each position's value
  double variance = 0;  // of a walk of strength 1 about it
};

Weights weights_at(double zoom, std::span<const ZoomLens> lenses) {
  const auto count = static_cast<Eigen::Index>(lenses.size()), powers = std::min<Eigen::Index>(4, count);
  const double first = lenses.front().zoom, range = lenses.back().zoom - first;
  const auto place = [&](Eigen::Index i) { return (lenses[static_cast<std::size_t>(i)].zoom - first) / range; };
  const double at = (zoom - first) / range;
  Eigen::MatrixXd system = Eigen::MatrixXd::Zero(count + powers, count + powers);
  Eigen::VectorXd right(count + powers);
  for (Eigen::Index i = 0; i < count; ++i) {
    for (Eigen::Index j = 0; j < count; ++j) system(i, j) = std::pow(std::abs(place(i) - place(j)), 3);
    for (Eigen::Index power = 0; power < powers; ++power)
      system(i, count + power) = system(count + power, i) = std::pow(place(i), power);
    right(i) = std::pow(std::abs(at - place(i)), 3);
  }
  for (Eigen::Index power = 0; power < powers; ++power) right(count + power) = std::pow(at, power);
  Weights weights;
  weights.of = system.partialPivLu().solve(right).head(count);
  weights.variance =
      std::max(0.0, weights.of.dot(system.topLeftCorner(count, count) * weights.of - 2 * right.head(count)));
  return weights;
}

double unit_of(std::span<const ZoomLens> lenses) noexcept { return lenses.front().camera.fx_px; }

Values value_at(const Weights& weights, std::span<const ZoomLens> lenses, double unit_px) {
  Values sum = Values::Zero();
  for (std::size_t i = 0; i < lenses.size(); ++i)
    sum += weights.of(static_cast<Eigen::Index>(i)) * values_of(lenses[i].camera, unit_px);
  return sum;
}

std::vector<ZoomLens> without(const std::vector<ZoomLens>& lenses, std::size_t which) {
  std::vector<ZoomLens> others = lenses;
  others.erase(others.begin() + static_cast<std::ptrdiff_t>(which));
  return others;
}

/// Of each gap: what its own ends, as far as they are inner positions, say of the walk, and what all of them say on
/// average. One alone may be foretold well by chance; the average alone does not see a lens that bends at one end.
std::vector<IntrinsicCovariance> strengths_of(const std::vector<ZoomLens>& lenses) {
  std::vector<IntrinsicCovariance> of_inner;
  IntrinsicCovariance average = IntrinsicCovariance::Zero();
  for (std::size_t i = 1; i + 1 < lenses.size(); ++i) {
    const std::vector<ZoomLens> others = without(lenses, i);
    const double unit_px = unit_of(lenses);
    const Weights weights = weights_at(lenses[i].zoom, others);
    const Values off = value_at(weights, others, unit_px) - values_of(lenses[i].camera, unit_px);
    of_inner.emplace_back(off * off.transpose() / weights.variance);
    average += of_inner.back() / static_cast<double>(lenses.size() - 2);
  }
  std::vector<IntrinsicCovariance> strengths;
  for (std::size_t gap = 0; gap + 1 < lenses.size(); ++gap) {
    const std::size_t left = gap == 0 ? 0 : gap - 1, right = std::min(gap, of_inner.size() - 1);
    strengths.emplace_back(average + (of_inner[left] + of_inner[right]) / 2);
  }
  return strengths;
}

}  // namespace

std::optional<std::string> what_zooms_lack(const std::vector<ZoomLens>& lenses) {
  if (lenses.size() < 2) return "a zoom needs two positions at least";
  if (lenses.size() > kMostZooms)
    return fmt::format("{} positions are too many; take {} at most", lenses.size(), kMostZooms);
  const CameraModel& first = lenses.front().camera;
  for (std::size_t i = 1; i < lenses.size(); ++i) {
    const CameraModel &camera = lenses[i].camera, &before = lenses[i - 1].camera;
    if (lenses[i].zoom == lenses[i - 1].zoom) return fmt::format("position {} is there twice", lenses[i].zoom);
    EXPECTS(lenses[i].zoom > lenses[i - 1].zoom);
    if (camera.width_px != first.width_px || camera.height_px != first.height_px)
      return fmt::format("position {} has pictures of {}x{} px, position {} of {}x{}", lenses[i].zoom, camera.width_px,
                         camera.height_px, lenses.front().zoom, first.width_px, first.height_px);
    if (camera.model != first.model)
      return fmt::format("position {} has another lens model than position {}", lenses[i].zoom, lenses.front().zoom);
    const bool rises = lenses[1].camera.fx_px > first.fx_px;
    if (camera.fx_px == before.fx_px)
      return fmt::format("the focal length is {:.1f} px at both {} and {}; are the positions right?", camera.fx_px,
                         lenses[i - 1].zoom, lenses[i].zoom);
    if ((camera.fx_px > before.fx_px) != rises)
      return fmt::format(
          "the focal length does not {} all along: {:.1f} px at position {}, {:.1f} px at {}; are the positions right?",
          rises ? "rise" : "fall", before.fx_px, lenses[i - 1].zoom, camera.fx_px, lenses[i].zoom);
  }
  return std::nullopt;
}

ZoomTable::ZoomTable(std::vector<ZoomLens> lenses) : lenses_(std::move(lenses)) {
  EXPECTS(!what_zooms_lack(lenses_));
  if (knows_between()) strengths_ = strengths_of(lenses_);
}

/// Anywhere between the first position and the last.
ZoomLens ZoomTable::between(double zoom) const {
  const double unit_px = unit_of(lenses_);
  const Weights weights = weights_at(zoom, lenses_);
  ZoomLens lens;
  lens.zoom = static_cast<int>(std::lround(zoom));
  lens.camera = camera_of(value_at(weights, lenses_, unit_px), lenses_.front().camera, unit_px);
  IntrinsicCovariance of_values = IntrinsicCovariance::Zero();
  for (std::size_t i = 0; i < lenses_.size(); ++i) {
    const IntrinsicCovariance by = intrinsics_by_values(lenses_[i].camera, unit_px).inverse();
    const double weight = weights.of(static_cast<Eigen::Index>(i));
    of_values += weight * weight * (by * lenses_[i].covariance * by.transpose());
  }
  if (knows_between()) {
    const auto next = std::ranges::upper_bound(lenses_, zoom, {}, &ZoomLens::zoom);
    const auto gap = std::clamp<std::ptrdiff_t>(next - lenses_.begin() - 1, 0, std::ssize(strengths_) - 1);
    of_values += weights.variance * strengths_[static_cast<std::size_t>(gap)];
  }
  const Values slope = value_at(weights_at(zoom + 0.5, lenses_), lenses_, unit_px) -
                       value_at(weights_at(zoom - 0.5, lenses_), lenses_, unit_px);  // per step
  of_values += kRounding_steps2 * slope * slope.transpose();
  const IntrinsicCovariance by = intrinsics_by_values(lens.camera, unit_px);
  const IntrinsicCovariance covariance = by * of_values * by.transpose();
  lens.covariance = (covariance + covariance.transpose()) / 2;
  return lens;
}

std::optional<ZoomLens> ZoomTable::at(int zoom) const {
  const bool is_one = std::ranges::find(lenses_, zoom, &ZoomLens::zoom) != lenses_.end();
  const bool is_within = zoom >= lenses_.front().zoom && zoom <= lenses_.back().zoom;
  if (!is_one && !(knows_between() && is_within)) return std::nullopt;
  return between(zoom);
}

std::string ZoomTable::reach() const {
  if (knows_between()) return fmt::format("{} to {}", lenses_.front().zoom, lenses_.back().zoom);
  std::vector<int> zooms;
  for (const ZoomLens& lens : lenses_) zooms.push_back(lens.zoom);
  return fmt::format("{} and {} alone", fmt::join(zooms.begin(), zooms.end() - 1, ", "), zooms.back());
}

const ZoomLens& ZoomTable::widest() const noexcept {
  return *std::ranges::min_element(lenses_, {}, [](const ZoomLens& lens) { return lens.camera.fx_px; });
}

std::vector<HeldOutZoom> ZoomTable::held_out() const {
  EXPECTS(knows_between());
  std::vector<HeldOutZoom> all;
  for (std::size_t i = 1; i + 1 < lenses_.size(); ++i) {
    const std::vector<ZoomLens> others = without(lenses_, i);
    const double unit_px = unit_of(others);
    const Values foretold = value_at(weights_at(lenses_[i].zoom, others), others, unit_px);
    all.push_back({lenses_[i].zoom, camera_of(foretold, lenses_[i].camera, unit_px)});
  }
  return all;
}

ZoomGap ZoomTable::worst_gap() const {
  EXPECTS(knows_between());
  ZoomGap worst;
  for (std::size_t i = 0; i + 1 < lenses_.size(); ++i) {
    const int from = lenses_[i].zoom, to = lenses_[i + 1].zoom, middle = from + (to - from) / 2;
    const ZoomLens lens = between(middle);
    const double sigma = std::sqrt(lens.covariance(0, 0)) / lens.camera.fx_px;
    if (!(sigma <= worst.focal_sigma)) worst = {from, to, middle, sigma};
  }
  return worst;
}

std::optional<ZoomGap> ZoomTable::turning_gap() const {
  EXPECTS(knows_between());
  constexpr int kLooks = 16;  // in each gap
  const double unit_px = unit_of(lenses_);
  const bool rises = lenses_[1].camera.fx_px > lenses_[0].camera.fx_px;
  for (std::size_t i = 0; i + 1 < lenses_.size(); ++i) {
    const int from = lenses_[i].zoom, to = lenses_[i + 1].zoom;
    double before = std::log(lenses_[i].camera.fx_px);
    for (int look = 1; look <= kLooks; ++look) {
      const double zoom = from + (to - from) * static_cast<double>(look) / kLooks;
      const double now = value_at(weights_at(zoom, lenses_), lenses_, unit_px)(0);
      if ((now > before) != rises) return ZoomGap{from, to, from + (to - from) / 2, 0};
      before = now;
    }
  }
  return std::nullopt;
}

std::optional<std::string> what_gaps_lack(const ZoomTable& table) {
  constexpr double kMaxFocalShare = 0.01;  // 1-sigma
  if (!table.knows_between()) return std::nullopt;
  if (const auto gap = table.turning_gap())
    return fmt::format("between {} and {} the focal length would turn back: record one at {}, or correct the positions",
                       gap->from, gap->to, gap->worst);
  const ZoomGap gap = table.worst_gap();
  if (gap.focal_sigma <= kMaxFocalShare) return std::nullopt;
  return fmt::format("between {} and {} the focal length is foretold to {:.2g} %: record one at {}", gap.from, gap.to,
                     100 * gap.focal_sigma, gap.worst);
}

}  // namespace ninedot
