#include "calibrate_camera/model_choice.h"

#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "calibrate_camera/lens_parameters.h"

namespace ninedot {
namespace {

constexpr std::size_t kFolds = 4;
/// What another model's loss must be lower by to be worth its parameters, as a logarithm: at 10 % of the loss residuals
/// are 5 % smaller.
constexpr double kWorth = 0.1, kStandardErrors = 2;
/// No more outlines than so many are looked at in all: the difference between two models needs no more.
constexpr std::size_t kMostEdges = 12000;
/// Along the radius, where one model's bending is put into another one's words.
constexpr int kSamples = 64;

/// Loss in each view while it was not fitted, and what its outlines were off.
struct HeldOut {
  std::vector<double> losses;
  double squares_px2 = 0, outlines = 0;
  double rms_px() const { return std::sqrt(squares_px2 / std::max(1.0, outlines)); }
};

std::vector<SheetView> thinned(std::span<const SheetView> views) {
  std::vector<SheetView> result;
  std::size_t edges = 0;
  for (const SheetView& view : views) edges += view.edges.size();
  const std::size_t every = 1 + edges / kMostEdges;
  for (const SheetView& view : views) {
    SheetView& thin = result.emplace_back();
    thin.seen = view.seen;
    for (std::size_t i = 0; i < view.edges.size(); i += every) thin.edges.push_back(view.edges[i]);
  }
  return result;
}

/// How far from the middle the lens puts what is seen at `r` from its axis. [1]
double bent(const CameraModel& radial, double r) { return radial.distort({r, 0}).x(); }

/// Polynomials of the lens's bending: in powers of the radius, or of the angle for a fisheye.
Eigen::VectorXd polynomial_of(const CameraModel& radial, double reach, bool of_angle) {
  const int count = of_angle ? 4 : 3;
  Eigen::MatrixXd terms(kSamples, count);
  Eigen::VectorXd rest(kSamples);
  for (int i = 0; i < kSamples; ++i) {
    const double r = reach * (i + 1) / kSamples, x = of_angle ? std::atan(r) : r;
    rest(i) = bent(radial, r) - x;
    for (int term = 0; term < count; ++term) terms(i, term) = std::pow(x, 2 * term + 3);
  }
  return terms.colPivHouseholderQr().solve(rest);
}

/// r N(r^2) - d D(r^2) = 0 is linear in both. A fisheye's bending is far from any polynomial's: from one the adjustment
/// does not find the way to the denominator that it needs.
/// \return  of N, then of D
Eigen::VectorXd quotient_of(const CameraModel& radial, double reach) {
  constexpr double kSmallest = 1e-3;  // of all quotients that do, one of small coefficients
  Eigen::MatrixXd terms = Eigen::MatrixXd::Zero(kSamples + 6, 6);
  Eigen::VectorXd rest = Eigen::VectorXd::Zero(kSamples + 6);
  for (int i = 0; i < kSamples; ++i) {
    const double r = reach * (i + 1) / kSamples, d = bent(radial, r);
    rest(i) = d - r;
    for (int term = 0; term < 3; ++term) {
      const double power = std::pow(r, 2 * term + 2);
      terms(i, term) = r * power, terms(i, term + 3) = -d * power;
    }
  }
  terms.bottomRows<6>().diagonal().setConstant(kSmallest);
  return terms.colPivHouseholderQr().solve(rest);
}

/// The same lens in another model's words, near enough to start from: coefficients by least squares along the radius.
LensFit in_model(LensFit fit, DistortionModel model) {
  if (fit.camera.model == model) return fit;
  CameraModel radial = fit.camera;
  const bool was_polynomial = radial.model != DistortionModel::kEquidistant;
  if (was_polynomial) radial.k[2] = radial.k[3] = 0;
  const Result<Eigen::Vector2d> corner = radial.normalised_from_pixel({0, 0});
  const double reach = corner ? corner->norm() : corner_radius(radial);
  std::array<double, 8> k{};
  if (model == DistortionModel::kEquidistant) {
    const Eigen::VectorXd of_angle = polynomial_of(radial, reach, true);
    std::copy_n(of_angle.data(), 4, k.data());
  } else if (was_polynomial || model == DistortionModel::kPlumbBob) {
    const Eigen::VectorXd of_radius = polynomial_of(radial, reach, false);
    k = {of_radius(0), of_radius(1), 0, 0, of_radius(2)};
  } else {
    const Eigen::VectorXd quotient = quotient_of(radial, reach);
    k = {quotient(0), quotient(1), 0, 0, quotient(2), quotient(3), quotient(4), quotient(5)};
  }
  if (was_polynomial && model != DistortionModel::kEquidistant) k[2] = fit.camera.k[2], k[3] = fit.camera.k[3];
  fit.camera.model = model;
  fit.camera.k = k;
  return fit;
}

void look_at(std::span<const PlaneDisc> discs, const SheetView& view, const LensFit& trained, const ViewState& start,
             HeldOut& held_out) {
  const std::optional<ViewFit> fit = fit_view(trained.camera, discs, view, trained.floor_px, &start);
  if (!fit) {
    held_out.losses.push_back(25.0 * static_cast<double>(view.edges.size()));
    return;
  }
  held_out.losses.push_back(fit->loss);
  const std::vector<double> off_px = edge_residuals_px(trained.camera, discs, view, fit->state);
  for (const double off : off_px) {
    held_out.squares_px2 += std::isfinite(off) ? std::min(1.0, off * off) : 1;
    ++held_out.outlines;
  }
}

/// \return  nothing: the model fits not even the views that it is given
std::optional<HeldOut> hold_out(std::span<const PlaneDisc> discs, std::span<const SheetView> views, const LensFit& all,
                                const ModelChoiceOptions& options) {
  HeldOut held_out;
  for (std::size_t fold = 0; fold < kFolds; ++fold) {
    std::vector<SheetView> shown;
    LensFit trained{all.camera, {}, all.floor_px, 0};
    for (std::size_t i = 0; i < views.size(); ++i)
      if (i % kFolds != fold) shown.push_back(views[i]), trained.views.push_back(all.views[i]);
    if (!adjust_lens(discs, shown, trained, options.adjust)) return std::nullopt;
    for (std::size_t i = fold; i < views.size(); i += kFolds) look_at(discs, views[i], trained, all.views[i], held_out);
  }
  return held_out;
}

/// Whether `other` foretells better, beyond chance and by enough. View by view, by the ratio of the losses: a view that
/// one of them misses by far says no more than that, and would else be all of the mean and of its error.
bool is_better(const HeldOut& other, const HeldOut& now) {
  const auto count = static_cast<double>(now.losses.size());
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < now.losses.size(); ++i) {
    const double gain = std::log((now.losses[i] + 1) / (other.losses[i] + 1));  // + 1: where neither is off
    sum += gain, squares += gain * gain;
  }
  const double mean = sum / count, variance = std::max(0.0, squares / count - mean * mean);
  return mean > kStandardErrors * std::sqrt(variance / count) && mean > kWorth;
}

}  // namespace

std::optional<LensFit> choose_model(std::span<const PlaneDisc> discs, std::span<const SheetView> views,
                                    const LensFit& fit, const ModelChoiceOptions& options,
                                    std::vector<TriedModel>& tried) {
  struct Candidate {
    LensFit fit;
    std::optional<HeldOut> held_out;
  };
  const std::vector<SheetView> looked_at = thinned(views);
  std::vector<Candidate> candidates;
  double floor_px = std::numeric_limits<double>::infinity();
  for (const DistortionModel model :
       {DistortionModel::kPlumbBob, DistortionModel::kEquidistant, DistortionModel::kRationalPolynomial}) {
    // A richer model starts from the best so far.
    const LensFit* start = &fit;
    for (const Candidate& candidate : candidates)
      if (candidate.fit.loss < start->loss && model == DistortionModel::kRationalPolynomial &&
          candidate.fit.camera.model == DistortionModel::kPlumbBob)
        start = &candidate.fit;
    LensFit own = in_model(*start, model);
    own.floor_px = fit.floor_px;
    if (!options.go_on("lens models")) return std::nullopt;
    if (!adjust_lens(discs, looked_at, own, options.adjust)) {
      tried.push_back({model, std::numeric_limits<double>::infinity()});
      continue;
    }
    floor_px = std::min(floor_px, unexplained_px(discs, looked_at, own));
    candidates.push_back({std::move(own), std::nullopt});
  }
  // One floor for all: that of the one that explains most, so that losses can be compared.
  const Candidate* chosen = nullptr;
  for (Candidate& candidate : candidates) {
    candidate.fit.floor_px = floor_px;
    if (!options.go_on("lens models, on views left out")) return std::nullopt;
    candidate.held_out = hold_out(discs, looked_at, candidate.fit, options);
    tried.push_back({candidate.fit.camera.model,
                     candidate.held_out ? candidate.held_out->rms_px() : std::numeric_limits<double>::infinity()});
    if (candidate.held_out && (chosen == nullptr || is_better(*candidate.held_out, *chosen->held_out)))
      chosen = &candidate;
  }
  std::ranges::sort(tried, {}, &TriedModel::held_out_px);
  if (chosen == nullptr) return std::nullopt;
  return chosen->fit;
}

}  // namespace ninedot
