#include "calibrate_camera/lens_prior.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "calibrate_camera/lens_parameters.h"

namespace ninedot {
namespace {

constexpr double kCornerBend = 0.4;
/// Of N / D: three coefficients of kCornerBend each.
constexpr double kBend = 0.7;
/// D in the picture's corner, and the 1-sigma of its logarithm: lenses that are sold with such coefficients have 0.4 to
/// 100, whose middle is 6, times or through 7.
constexpr double kCornerD = 6, kCornerLogD = 2;
/// Where a lens folds back the corner has no direction; no lens bends it further in than to half.
constexpr double kMostReach = 2;

/// Where in a rational polynomial's coefficients the powers of r^2 are: k1, k2, k3 and k4, k5, k6.
constexpr std::array<Eigen::Index, 3> kNumerator{0, 1, 4}, kDenominator{5, 6, 7};

/// The picture's corners, at f = 1 and without distortion.
double reach_of(const CameraModel& lens) {
  const double bent = corner_radius(lens);
  double reach = bent;
  for (const double x_px : {0.0, lens.width_px - 1.0})
    for (const double y_px : {0.0, lens.height_px - 1.0})
      if (const Result<Eigen::Vector2d> ray = lens.normalised_from_pixel({x_px, y_px}))
        reach = std::max(reach, ray->norm());
  return std::min(reach, kMostReach * bent);
}

}  // namespace

LensPrior::LensPrior(const CameraModel& lens) : model_(lens.model) {
  const int coefficients = coefficient_count(model_);
  sigmas_ = Eigen::VectorXd::Constant(coefficients, std::numeric_limits<double>::infinity());
  const bool is_equidistant = model_ == DistortionModel::kEquidistant;
  const double r = is_equidistant ? std::atan(corner_radius(lens)) : corner_radius(lens);
  const auto set = [&](int coefficient, int power) { sigmas_(coefficient) = kCornerBend / std::pow(r, power); };
  count_ = coefficients;
  if (is_equidistant) {
    for (int i = 0; i < coefficients; ++i) set(i, 2 * (i + 1));
    return;
  }
  set(2, 1), set(3, 1);  // p1, p2
  if (model_ == DistortionModel::kPlumbBob) {
    set(0, 2), set(1, 4), set(4, 6);  // k1, k2, k3
    return;
  }
  const double reach = reach_of(lens);
  for (std::size_t i = 0; i < kRadii; ++i)
    squared_radii_[i] = std::pow(reach * static_cast<double>(i + 1) / static_cast<double>(kRadii), 2);
  count_ += 2 * static_cast<Eigen::Index>(kRadii);
}

bool LensPrior::evaluate(const Eigen::Ref<const Eigen::VectorXd>& values, Eigen::VectorXd& residuals,
                         Eigen::MatrixXd* jacobian) const {
  const Eigen::VectorXd k = values.tail(sigmas_.size());
  residuals = Eigen::VectorXd::Zero(count_);
  residuals.head(k.size()) = k.cwiseQuotient(sigmas_);
  if (jacobian != nullptr) {
    *jacobian = Eigen::MatrixXd::Zero(count_, values.size());
    jacobian->block(0, kPlainIntrinsics, k.size(), k.size()) = sigmas_.cwiseInverse().asDiagonal();
  }
  if (model_ != DistortionModel::kRationalPolynomial) return true;
  Eigen::Index row = k.size();
  for (std::size_t at = 0; at < kRadii; ++at) {
    const double r2 = squared_radii_[at], share = r2 / squared_radii_.back();
    const double usual = std::log(1 + (kCornerD - 1) * share), spread = kCornerLogD * std::sqrt(share);
    const std::array<double, 3> powers{r2, r2 * r2, r2 * r2 * r2};
    double N = 1, D = 1;
    for (std::size_t i = 0; i < 3; ++i) N += powers[i] * k(kNumerator[i]), D += powers[i] * k(kDenominator[i]);
    if (!(D > 0)) return false;
    residuals(row) = (N / D - 1) / kBend, residuals(row + 1) = (std::log(D) - usual) / spread;
    for (std::size_t i = 0; jacobian != nullptr && i < 3; ++i) {
      (*jacobian)(row, kPlainIntrinsics + kNumerator[i]) = powers[i] / D / kBend;
      (*jacobian)(row, kPlainIntrinsics + kDenominator[i]) = -N / (D * D) * powers[i] / kBend;
      (*jacobian)(row + 1, kPlainIntrinsics + kDenominator[i]) = powers[i] / D / spread;
    }
    row += 2;
  }
  return true;
}

}  // namespace ninedot
