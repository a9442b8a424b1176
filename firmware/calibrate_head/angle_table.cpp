#include "calibrate_head/angle_table.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>

#include "base/contract.h"
#include "base/units.h"

namespace ninedot {
namespace {

/// Nine over 90 degrees tell a servo's usual bend from its noise; what is finer is its gears' teeth.
constexpr std::array<std::size_t, 5> kKnotCounts{2, 3, 4, 6, 9};
/// A knot needs as much as one whole stop that is nearest to it; else its value is made up.
constexpr double kLeastSupport = 1.5;
constexpr double kBetter = 0.97;
constexpr std::size_t kFolds = 5;
/// Stops that are told to be as near as this are one place.
constexpr double kSamePlace_rad = 0.3 * kRadPerDeg;

/// The values of the knots, and the lag last.
Eigen::VectorXd fit_values(std::span<const AxisStop> stops, std::span<const double> knots,
                           const std::vector<bool>& is_used) {
  const auto columns = static_cast<Eigen::Index>(knots.size()) + 1;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(stops.size()) + 1, columns);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(A.rows());
  for (std::size_t i = 0; i < stops.size(); ++i) {
    if (!is_used[i]) continue;
    const auto row = static_cast<Eigen::Index>(i);
    A.row(row).head(columns - 1) = knot_weights(knots, stops[i].told_rad);
    A(row, columns - 1) = -stops[i].side;
    b(row) = stops[i].angle_rad;
  }
  A(A.rows() - 1, columns - 1) = 1e-3;  // where no side is known there is no lag
  return A.colPivHouseholderQr().solve(b);
}

bool are_supported(std::span<const AxisStop> stops, std::span<const double> knots) {
  Eigen::VectorXd support = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(knots.size()));
  for (const AxisStop& stop : stops) support += knot_weights(knots, stop.told_rad).cwiseAbs2();
  return support.minCoeff() >= kLeastSupport;
}

/// Which fold a stop is left out with. What a place errs by is alike each time, so that it is left out as a whole;
/// neighbours in different folds, and the outermost places in none: nothing can foretell those.
struct Folds {
  std::vector<std::size_t> of_stop;
  std::size_t places = 0;
};
constexpr std::size_t kNoFold = kFolds;

Folds folds_of(std::span<const AxisStop> stops) {
  std::vector<std::size_t> order(stops.size()), place(stops.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return stops[i].told_rad; });
  Folds folds{std::vector<std::size_t>(stops.size(), kNoFold), 0};
  for (std::size_t k = 0; k < order.size(); ++k) {
    if (k > 0 && stops[order[k]].told_rad - stops[order[k - 1]].told_rad > kSamePlace_rad) ++folds.places;
    place[order[k]] = folds.places;
  }
  for (std::size_t i = 0; i < stops.size(); ++i)
    if (place[i] > 0 && place[i] < folds.places) folds.of_stop[i] = place[i] % kFolds;
  ++folds.places;
  return folds;
}

/// Root mean square of what stops that were left out differ by from the others' table. [rad]
double held_out_rad(std::span<const AxisStop> stops, const Folds& folds, std::span<const double> knots) {
  double sum = 0, count = 0;
  for (std::size_t fold = 0; fold < kFolds; ++fold) {
    std::vector<bool> is_used(stops.size());
    for (std::size_t i = 0; i < stops.size(); ++i) is_used[i] = folds.of_stop[i] != fold;
    const Eigen::VectorXd values = fit_values(stops, knots, is_used);
    for (std::size_t i = 0; i < stops.size(); ++i) {
      if (is_used[i]) continue;
      const double foretold_rad = knot_weights(knots, stops[i].told_rad).dot(values.head(values.size() - 1)) -
                                  stops[i].side * values(values.size() - 1);
      sum += (stops[i].angle_rad - foretold_rad) * (stops[i].angle_rad - foretold_rad), ++count;
    }
  }
  return count > 0 ? std::sqrt(sum / count) : 0;
}

}  // namespace

Eigen::VectorXd knot_weights(std::span<const double> knots_rad, double told_rad) {
  EXPECTS(knots_rad.size() >= 2);
  std::size_t i = 1;
  while (i + 1 < knots_rad.size() && told_rad > knots_rad[i]) ++i;
  const double part = (told_rad - knots_rad[i - 1]) / (knots_rad[i] - knots_rad[i - 1]);
  Eigen::VectorXd weights = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(knots_rad.size()));
  weights(static_cast<Eigen::Index>(i) - 1) = 1 - part;
  weights(static_cast<Eigen::Index>(i)) = part;
  return weights;
}

double anchor_rad(std::span<const double> knots_rad) { return std::clamp(0.0, knots_rad.front(), knots_rad.back()); }

double AngleTable::at(double told) const {
  return knot_weights(told_rad, told)
      .dot(Eigen::Map<const Eigen::VectorXd>(angle_rad.data(), static_cast<Eigen::Index>(angle_rad.size())));
}

std::vector<double> even_knots(std::span<const AxisStop> stops, std::size_t count) {
  EXPECTS(count >= 2 && !stops.empty());
  const auto [low, high] = std::ranges::minmax(stops, {}, &AxisStop::told_rad);
  std::vector<double> knots(count);
  for (std::size_t i = 0; i < count; ++i)
    knots[i] = low.told_rad + (high.told_rad - low.told_rad) * static_cast<double>(i) / static_cast<double>(count - 1);
  return knots;
}

std::vector<double> choose_knots(std::span<const AxisStop> stops) {
  EXPECTS(stops.size() >= 5);
  std::vector<double> chosen = even_knots(stops, 2);
  const Folds folds = folds_of(stops);
  double least_rad = held_out_rad(stops, folds, chosen);
  for (const std::size_t count : kKnotCounts) {
    if (count == 2) continue;
    if (2 * count > folds.places + 1) break;  // the play, up here and down there, would bend it
    const std::vector<double> knots = even_knots(stops, count);
    if (!are_supported(stops, knots)) break;
    const double off_rad = held_out_rad(stops, folds, knots);
    if (off_rad > kBetter * least_rad) continue;
    chosen = knots, least_rad = off_rad;
  }
  return chosen;
}

}  // namespace ninedot
