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
/// What another model's loss must be lower by to be worth its parameters: at 10 % of the loss residuals are 5 %
/// smaller.
constexpr double kWorth = 0.1, kStandardErrors = 2;
/// No more outlines than so many are looked at in all: the difference between two models needs no more.
constexpr std::size_t kMostEdges = 12000;

/// Loss in each view while it was not fitted, and what its outlines were off.
struct HeldOut {
  std::vector<double> losses;
  double squares_px2 = 0, outlines = 0;
  double rms_px() const { return std::sqrt(squares_px2 / std::max(1.0, outlines)); }
  double mean() const {
    double sum = 0;
    for (const double loss : losses) sum += loss;
    return sum / static_cast<double>(losses.size());
  }
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

/// The same lens in another model's words, near enough to start from: coefficients by least squares along the radius.
LensFit in_model(LensFit fit, DistortionModel model) {
  if (fit.camera.model == model) return fit;
  constexpr int kSamples = 64;
  CameraModel radial = fit.camera;
  const bool is_polynomial = model != DistortionModel::kEquidistant;
  const bool was_polynomial = radial.model != DistortionModel::kEquidistant;
  if (was_polynomial) radial.k[2] = radial.k[3] = 0;
  const Result<Eigen::Vector2d> corner = radial.normalised_from_pixel({0, 0});
  const double reach = corner ? corner->norm() : corner_radius(radial);
  const int count = is_polynomial ? 3 : 4;
  Eigen::MatrixXd terms(kSamples, count);
  Eigen::VectorXd rest(kSamples);
  for (int i = 0; i < kSamples; ++i) {
    const double r = reach * (i + 1) / kSamples, x = is_polynomial ? r : std::atan(r);
    rest(i) = radial.distort({r, 0}).x() - x;
    for (int term = 0; term < count; ++term) terms(i, term) = std::pow(x, 2 * term + 3);
  }
  const Eigen::VectorXd k = terms.colPivHouseholderQr().solve(rest);
  const std::array<double, 8> before = fit.camera.k;
  fit.camera.model = model;
  fit.camera.k = {};
  if (!is_polynomial) {
    for (int i = 0; i < count; ++i) fit.camera.k[static_cast<std::size_t>(i)] = k(i);
    return fit;
  }
  fit.camera.k[0] = k(0), fit.camera.k[1] = k(1), fit.camera.k[4] = k(2);
  if (was_polynomial) fit.camera.k[2] = before[2], fit.camera.k[3] = before[3];
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

/// Whether `other` foretells better, beyond chance and by enough.
bool is_better(const HeldOut& other, const HeldOut& now) {
  const auto count = static_cast<double>(now.losses.size());
  double sum = 0, squares = 0;
  for (std::size_t i = 0; i < now.losses.size(); ++i) {
    const double gain = now.losses[i] - other.losses[i];
    sum += gain, squares += gain * gain;
  }
  const double mean = sum / count, variance = std::max(0.0, squares / count - mean * mean);
  return mean > kStandardErrors * std::sqrt(variance / count) && mean > kWorth * now.mean();
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
